// SPDX-License-Identifier: Apache-2.0
// Input files: exit code 3, one line, and values of a limit that are no numbers.
#include <sys/stat.h>

#include <fstream>

#include "cli_support.h"

using namespace lucarium::test;

TEST_CASE("a gate of NaN always passed") {
  const TemporaryFolder folder;
  std::vector<std::string> images;
  for (const char* red : {"0.2", "0.9"}) {
    images.push_back((folder.path() / (std::string(red) + ".exr")).string());
    REQUIRE(run_lucarium("render builtin:cornell " + constant_technique(std::string("red=") + red) +
                         "--iterations 1 --quiet -o " + images.back())
                .exit_code == 0);
  }
  const std::string diff = "diff " + images[0] + " " + images[1] + " --max-relmse ";
  for (const char* bar : {"nan", "inf", "-1", "x"}) {
    check_refused(diff + bar, 2, std::string("--max-relmse: '") + bar + "' is not a number from 0");
  }
  CHECK(run_lucarium(diff + "1e-6").exit_code == 1);
  CHECK(run_lucarium(diff + "100").exit_code == 0);
}

TEST_CASE("a cut PNG gives one line, without libpng's own") {
  const TemporaryFolder folder;
  const std::string whole = (folder.path() / "a.png").string(), cut = (folder.path() / "cut.png").string();
  REQUIRE(
      run_lucarium("render builtin:cornell " + constant_technique() + "--iterations 1 --quiet -o " + whole).exit_code ==
      0);
  REQUIRE(run_program("head -c 100 " + whole + " > " + cut).exit_code == 0);
  const ProgramResult result = run_lucarium("diff " + cut + " " + whole);
  CHECK(result.exit_code == 3);
  CHECK(result.err == "lucarium: error: " + cut + ": damaged image: it is cut off\n");
}

TEST_CASE("input: exit code 3") {
  const TemporaryFolder folder;
  const std::string out = " -o " + (folder.path() / "a.exr").string() + " ";
  const std::string broken = (folder.path() / "broken.glb").string();
  std::ofstream(broken) << "glTF, but not really";
  check_refused("render /nonexistent/scene.gltf " + constant_technique() + out, 3, "/nonexistent/scene.gltf");
  check_refused("scene " + broken, 3, broken);
  check_refused("render builtin:cornell " + constant_technique() + "-o /proc/a.exr", 3, "/proc cannot be written into");
  check_refused("render builtin:cornell " + constant_technique() + "--material '*:emissive_factor=0,0,0'" + out, 3,
                "--environment");
  check_refused("diff /nonexistent/a.exr " + broken, 3, "/nonexistent/a.exr: no such file");
  CHECK(count_files(folder.path()) == 1);
}

TEST_CASE("a technique that computes no light needs none in the scene") {
  const TemporaryFolder folder;
  const std::string dark = " --material '*:emissive_factor=0,0,0' --size 16x9 --iterations 1 --quiet -o " +
                           (folder.path() / "a.exr").string();
  check_refused("render builtin:cornell -t voxel_abuffer:mode=cast,abuffer_size=128" + dark, 3, "has no light");
  CHECK(run_lucarium("render builtin:cornell -t voxel_abuffer:mode=ao,abuffer_size=128" + dark).exit_code == 0);
}

TEST_CASE("a file that is not there: the next step is said") {
  const TemporaryFolder folder;
  const std::string scene = (folder.path() / "kitchen.glb").string(), typo = (folder.path() / "kitchn.glb").string();
  std::ofstream(scene) << "glTF";
  check_refused("scene " + typo, 3, typo + ": no such file; did you mean 'kitchen.glb'?");
  check_refused("diff " + typo + " " + scene, 3, typo + ": no such file; did you mean 'kitchen.glb'?");
  check_refused("scene " + (folder.path() / "elsewhere.glb").string(), 3,
                "give a .gltf or .glb file, or one of builtin");
  check_refused("scene builtin:cornell --environment " + (folder.path() / "sky.hdr").string(), 3,
                "no such file; check its name");
  check_refused("diff /nonexistent/a.exr " + scene, 3, "there is no folder '/nonexistent'");
}

TEST_CASE("a pipe in the place of a file was waited for, for ever") {
  const TemporaryFolder folder;
  const std::string pipe = (folder.path() / "pipe").string(), scene = (folder.path() / "a.glb").string();
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  REQUIRE(run_lucarium("scene builtin:cornell --export " + scene).exit_code == 0);
  std::filesystem::remove(scene + ".lucarium.json");
  REQUIRE(::mkfifo((scene + ".lucarium.json").c_str(), 0600) == 0);
  for (const std::string& arguments :
       {"compare --comparison " + pipe + " -o " + (folder.path() / "out").string(), "job " + pipe, "scene " + scene,
        "scene builtin:cornell --environment " + pipe, "scene " + pipe, "diff " + pipe + " " + pipe}) {
    CAPTURE(arguments);
    const ProgramResult result = run_program(lucarium_program() + " " + arguments, 30);
    CHECK(result.exit_code == 3);
    CHECK((contains(result.err, "is a pipe or a device") || contains(result.err, "is not a regular file")));
  }
}
