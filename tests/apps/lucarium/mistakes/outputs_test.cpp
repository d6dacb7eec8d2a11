// SPDX-License-Identifier: Apache-2.0
// Outputs: nothing is replaced unasked, nothing is lost, nothing that a terminal obeys is printed.
#include <sys/stat.h>

#include <fstream>
#include <iterator>

#include "cli_support.h"
#include "file_bytes.h"

using namespace lucarium::test;

TEST_CASE("two outputs of one name, of which the later replaced the earlier, are a mistake") {
  const TemporaryFolder folder;
  const std::string png = (folder.path() / "a.png").string(), same = (folder.path() / "." / "a.png").string(),
                    render = "render builtin:cornell " + constant_technique() + "--iterations 1 -o " + png;
  check_refused(render + " --profile=" + png, 2, "a.png: the name must end in .json");
  check_refused(render + " -o " + png, 2, "are the same file");
  check_refused(render + " -o " + same, 2, "are the same file");
  check_refused("scene builtin:cornell --atlas " + png + " --atlas-view " + same, 2, "are the same file");
  CHECK(count_files(folder.path()) == 0);
}

TEST_CASE("a pipe or a device was replaced by the file that was to be written into it") {
  const TemporaryFolder folder;
  const std::string pipe = (folder.path() / "pipe.png").string();
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  for (const char* output : {"-t virtual_light_field --save-state ", "-t path_tracing -o "}) {
    check_refused("render builtin:cornell --overwrite " + std::string(output) + pipe, 2,
                  "pipe.png is a pipe, a device");
    CHECK(std::filesystem::is_fifo(pipe));
  }
}

TEST_CASE("a folder for manual pages that cannot be made is an input error; pages are replaced only when asked") {
  const TemporaryFolder folder;
  check_refused("man -o /proc/pages", 3, "cannot create the folder /proc/pages");
  const std::string out = " -o " + folder.path().string();
  const ProgramResult first = run_lucarium("man render" + out);
  CHECK(first.exit_code == 0);
  CHECK(first.out == (folder.path() / "lucarium-render.1").string() + "\n");
  check_refused("man" + out, 2, "exists; choose another name or give --overwrite");
  CHECK(count_files(folder.path()) == 1);
  CHECK(run_lucarium("man render --overwrite" + out).exit_code == 0);
}

TEST_CASE("a full disk replaced a good error map by an empty one, exit code 0") {
  const TemporaryFolder folder;
  const std::string image = (folder.path() / "a.exr").string(), map = (folder.path() / "map.png").string();
  REQUIRE(run_lucarium("render builtin:cornell -t path_tracing --size 32x32 --spp 1 --quiet -o " + image).exit_code ==
          0);
  REQUIRE(run_lucarium("diff " + image + " " + image + " --output " + map).exit_code == 0);
  const std::string before = bytes_of(map);
  // The shell counts in blocks of 512 bytes: room for messages, not for a map of noise.
  const std::string dark = (folder.path() / "b.exr").string();
  REQUIRE(run_lucarium("render builtin:cornell -t path_tracing --size 32x32 --spp 1 --seed 2 --quiet -o " + dark)
              .exit_code == 0);
  const ProgramResult full = run_program("trap '' XFSZ; ulimit -f 1; " + lucarium_program() + " diff " + image + " " +
                                         dark + " --overwrite --json --output " + map);
  CHECK(full.exit_code == 3);
  CHECK(contains(full.err, "map.png: File too large"));
  CHECK(bytes_of(map) == before);
}

TEST_CASE("standard output that cannot be written is an error, not a success") {
  const std::string full = " >/dev/full";
  const std::string message = "cannot write to standard output: No space left on device";
  for (const char* command : {"techniques", "techniques --json", "techniques --markdown", "devices --json",
                              "scene builtin:cornell", "scene builtin:cornell --json", "render --help"}) {
    check_refused(command + full, 3, message);
  }
  check_refused("render builtin:cornell " + constant_technique() + "--iterations 1 --json --quiet" + full, 3, message);
  check_refused("devices >&-", 3, "cannot write to standard output: Bad file descriptor");
}

TEST_CASE("control characters in names reach no terminal") {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "ansi.gltf").string();
  std::ofstream(file) << R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
    "extensionsUsed": ["EVIL_\u001b[31m"], "nodes": [{"mesh": 0, "name": "\u001b[1m"}],
    "meshes": [{"name": "\u001b[31mred", "primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
    "materials": [{"name": "\u001b[2J\u001b]0;evil\u0007\u009b31m\nlucarium: error: none"}],
    "buffers": [{"byteLength": 36,
      "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0],
      "max": [1, 1, 0]}]})";
  const auto check_clean = [](const ProgramResult& result) {
    for (const std::string& text : {result.out, result.err}) {
      CAPTURE(text);
      CHECK(text.find('\x1b') == std::string::npos);
      CHECK(text.find('\x07') == std::string::npos);
      CHECK(text.find("\xc2\x9b") == std::string::npos);
      CHECK(text.find("\nlucarium: error: none") == std::string::npos);
    }
  };
  const ProgramResult text = run_lucarium("scene " + file);
  CHECK(text.exit_code == 0);
  CHECK(contains(text.out, "\\u001b[2J\\u001b]0;evil\\u0007\\u009b31m\\u000alucarium: error: none"));
  check_clean(text);
  const ProgramResult json = run_lucarium("scene " + file + " --json");
  CHECK(nlohmann::json::parse(json.out)["materials"][0]["name"] ==
        "\x1b[2J\x1b]0;evil\x07\u009b"
        "31m\nlucarium: error: none");
  check_clean(json);
  const ProgramResult warned = run_lucarium("render " + file + " --environment 1 " + constant_technique() +
                                            "--iterations 1 -o " + (folder.path() / "a.png").string());
  CHECK(warned.exit_code == 0);
  check_clean(warned);
  check_clean(run_lucarium("render " + file + " -o $(printf 'a\\033[2J.exr') -t $(printf 'b\\033[2J')"));
  check_clean(run_lucarium("scene $(printf 'no\\033[2J.gltf')"));
}

TEST_CASE("existing files are refused before any work, and replaced only when asked") {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "a.exr").string();
  std::ofstream(file) << "precious";
  check_refused("render builtin:cornell " + constant_technique() + "-o " + file, 2,
                file + " exists; choose another name or give --overwrite");
  check_refused(
      "render builtin:cornell " + constant_technique() + "-o " + (folder.path() / "b.png").string() + " -o " + file, 2,
      "exists");
  check_refused("render builtin:cornell " + constant_technique() + "--frames 0:1 -o " + folder.path().string(), 2,
                ".exr or .png");
  std::string text;
  std::ifstream(file) >> text;
  CHECK(text == "precious");
  CHECK(count_files(folder.path()) == 1);
  CHECK(run_lucarium("render builtin:cornell " + constant_technique() + "--overwrite --iterations 1 -o " + file)
            .exit_code == 0);
  CHECK(std::filesystem::file_size(file) > 100);
}

TEST_CASE("a mistyped memory limit removed the results that it was to replace") {
  const TemporaryFolder folder;
  for (const char* name : {"comparison.json", "results.csv"}) std::ofstream(folder.path() / name) << "{}";
  const std::string compare =
      "compare builtin:cornell -t path_tracing --iterations 1 --overwrite -o " + folder.path().string();
  check_refused(compare + " --memory-limit abc", 2, "--memory-limit");
  check_refused(compare + " --device=-x", 2, "");
  CHECK(count_files(folder.path()) == 2);
}
