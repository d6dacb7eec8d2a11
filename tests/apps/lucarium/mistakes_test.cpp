// SPDX-License-Identifier: Apache-2.0
// Every class of mistake: its exit code, one line that says what to do, and nothing written.
#include <sys/stat.h>

#include <fstream>
#include <iterator>

#include "cli_support.h"

using namespace lucarium::test;

namespace {

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

TEST_CASE("memory that is missing names the parameters that need it") {
  const TemporaryFolder folder;
  const std::string common = " --size 64x64 --memory-limit 8M -o " + (folder.path() / "a.exr").string();
  check_refused("render builtin:cornell -t bundle_exchange" + common, 4, "lower --size or --texture-size, texels");
  check_refused("render builtin:cornell -t bundle_exchange:texels=500000" + common, 4,
                "lower --size or --texture-size, texels");
  check_refused("render builtin:cornell -t micro_rendering" + common, 4, "lower --size or --texture-size, points_log2");
}

TEST_CASE("a command that does not exist is a mistake even with --help") {
  check_refused("rendr --help", 2, "unknown command 'rendr'; did you mean 'render'?");
}

TEST_CASE("usage: exit code 2, and the nearest valid name") {
  const TemporaryFolder folder;
  const std::string out = " -o " + (folder.path() / "a.exr").string() + " ";
  check_refused("rendr builtin:cornell", 2, "did you mean 'render'?");
  check_refused("render builtin:cornell --sppp 3" + out, 2, "unknown option --sppp; did you mean '--spp'?");
  check_refused("render", 2, "scene is required");
  check_refused("render builtin:cornell", 2, "--output");
  check_refused("render builtin:cornell --spp 0" + out, 2, "--spp: '0' is not a whole number from 1");
  check_refused("render builtin:cornell --spp many" + out, 2, "--spp: 'many' is not a whole number from 1");
  check_refused("render builtin:cornell --time -1" + out, 2, "--time: '-1' is not a number above 0");
  check_refused("render builtin:cornell --time nan" + out, 2, "--time: 'nan' is not a number above 0");
  check_refused("render builtin:cornell --time inf" + out, 2, "--time: 'inf' is not a number above 0");
  check_refused("render builtin:cornell --size 64" + out, 2, "WIDTHxHEIGHT");
  check_refused("render builtin:cornell --size 0x64" + out, 2, "from 1 to 32768");
  check_refused("render builtin:cornell --max-bounces -2" + out, 2, "--max-bounces");
  check_refused("render builtin:cornell --pixel-sampling middle" + out, 2, "jitter, center");
  check_refused("render builtin:cornell --frames 3:1" + out, 2, "FIRST:LAST");
  check_refused("render builtin:cornell --frames 0:1 --at 1" + out, 2, "not both");
  check_refused("render builtin:cornell -p red=1" + out, 2, "no parameter is called 'red'");  // of path_tracing
  check_refused("render builtin:cornell -p red=1 -t constant" + out, 2, "name the technique it belongs to first");
  check_refused("compare builtin:cornell -p red=1 --iterations 1 " + out, 2, "name the technique it belongs to first");
  check_refused("render builtin:cornell -o " + (folder.path() / "a.jpg").string(), 2, ".exr or .png");
  check_refused("render builtin:cornell --memory-limit lots" + out, 2, "--memory-limit");
  check_refused("render builtin:cornell " + constant_technique() + "-t constant" + out, 2, "lucarium compare");
  check_refused("render builtin:cornell " + constant_technique("rde=1") + out, 2, "did you mean 'red'?");
  check_refused("render builtin:cornell " + constant_technique("red=-1") + out, 2, "0 … 100");
  check_refused("render builtin:cornell " + constant_technique() + "-p red=101" + out, 2,
                "parameter red: 101 is outside");
  check_refused("render builtin:cornell " + constant_technique("failure=nana") + out, 2, "did you mean 'nan'?");
  check_refused("render builtin:cornell " + constant_technique() + "--camera nonsense" + out, 2, "nonsense");
  check_refused("render builtin:cornell " + constant_technique() + "--light bulb:1" + out, 2, "point:X,Y,Z");
  check_refused("render builtin:cornell " + constant_technique() + "--material '*:shiny=1'" + out, 2, "shiny");
  check_refused("diff only-one.exr", 2, "reference is required");
  // A name that is mistyped, whatever it names.
  check_refused("scene builtin:cornel", 2, "did you mean 'cornell'?");
  check_refused("render builtin:cornell -t path_traicng" + out, 2, "did you mean 'path_tracing'?");
  check_refused("render builtin:cornell " + constant_technique() + "-o /nonexistent/folder/a.exr", 2,
                "there is no folder /nonexistent/folder");
  CHECK(count_files(folder.path()) == 0);
}

TEST_CASE("options that did nothing, and said nothing, are mistakes") {
  const TemporaryFolder folder;
  const std::string exr = " -o " + (folder.path() / "a.exr").string(),
                    png = " -o " + (folder.path() / "a.png").string(),
                    out = " -o " + (folder.path() / "results").string(), render = "render builtin:cornell ";
  check_refused(render + "--fps 12" + exr, 2, "--fps does nothing without --frames");
  check_refused(render + "--relmse 0.1" + exr, 2, "--relmse does nothing without --reference");
  check_refused(render + "--curve --json", 2, "--curve does nothing without --reference");
  check_refused(render + "--curve --reference a.exr --relmse 0.1" + exr, 2, "--curve does nothing without --json");
  check_refused(render + "--reference a.exr" + exr, 2, "--reference does nothing without --relmse or --json");
  check_refused(render + "--half" + png, 2, "--half does nothing without an --output FILE.exr");
  check_refused(render + "--exposure 1" + exr, 2, "--exposure does nothing without an --output FILE.png");
  check_refused(render + "--frames 0:1 --at 1" + exr, 2, "give --frames or --at, not both");
  check_refused(render + "--frames 0:1 --reference a.exr --json" + exr, 2, "give --frames or --reference, not both");

  const std::string compare = "compare builtin:cornell -t path_tracing" + out;
  check_refused(compare + " --time 1 --limit 5", 2, "--limit does nothing without --relmse");
  check_refused(compare + " --time 1 --reference a.exr --reference-spp 64", 2,
                "give --reference or --reference-spp, not both");
  check_refused(compare + " --time 1 --reference a.exr --reference-relmse 1", 2,
                "give --reference or --reference-relmse, not both");
  for (const char* stated : {"builtin:cornell",
                             "-t path_tracing",
                             "-p estimator=bsdf",
                             "--time 1",
                             "--iterations 1",
                             "--spp 1",
                             "--relmse 1",
                             "--seeds 2",
                             "--reference a.exr",
                             "--reference-spp 64",
                             "--reference-relmse 1",
                             "--fallback-environment 1",
                             "--size 8x8",
                             "--max-bounces 1",
                             "--pixel-sampling 2",
                             "--exposure 0",
                             "--camera 0",
                             "--environment 1",
                             "--light none",
                             "--material *:metallic=0",
                             "--no-sidecar",
                             "--texture-size 8",
                             "--at 1",
                             "--animation 0"}) {
    check_refused(std::string("compare --comparison study.json ") + stated + out, 2, "give --comparison or ");
  }

  const std::string reference = "reference builtin:cornell --path-set direct=off" + exr;
  check_refused(reference + " -t path_tracing", 2, "give --path-set or --technique, not both");
  check_refused(reference + " -p direct=on", 2, "give --path-set or --parameter, not both");
  check_refused(reference + " --max-bounces 2", 2, "give --path-set or --max-bounces, not both");
  check_refused("reference builtin:cornell --exposure 1" + exr, 2, "unknown option --exposure");

  for (const char* option :
       {"--atlas-texels 100", "--atlas-edge 0.1", "--atlas-texcoord1", "--device cpu", "--threads 1", "--cache-dir .",
        "--no-cache", "--memory-limit 1G", "--allocation-limit 1G"}) {
    check_refused(std::string("scene builtin:cornell ") + option, 2, "does nothing without --atlas or --atlas-view");
  }
  check_refused("scene builtin:cornell --atlas a.png --size 8x8", 2, "--size does nothing without --atlas-view");
  check_refused("scene builtin:cornell --atlas a.png --atlas-texels 9 --atlas-edge 1", 2, "not both");
  check_refused("devices --device cpu", 2, "unknown option --device");

  check_refused("diff a.exr b.exr --map-of signed", 2, "--map-of does nothing without --output");
  for (const char* option : {"--output a.png", "--max-relmse 1", "--exposure 1", "--formulas"})
    check_refused(std::string("diff a.exr b.exr --statistical ") + option, 2, "give --statistical or ");
  check_refused("diff a.exr b.exr --formulas --json", 2, "give --formulas or --json, not both");
  check_refused("techniques --markdown --json", 2, "give --markdown or --json, not both");
  for (const char* option :
       {"hermes2010", "--output x", "--overwrite", "--resume", "--dry-run", "--full", "--device 0"})
    check_refused(std::string("reproduce --list ") + option, 2, "give --list or ");
  CHECK(count_files(folder.path()) == 0);
}

TEST_CASE("options of the messages before the command's name were not seen by the rules about options") {
  check_refused("--json techniques --markdown", 2, "give --markdown or --json, not both");
  check_refused("--json diff a.exr b.exr --formulas", 2, "give --formulas or --json, not both");
  check_refused("--json commands --markdown", 2, "give --markdown or --json, not both");
  check_refused("commands --markdown --json", 2, "give --markdown or --json, not both");
  const TemporaryFolder folder;
  const std::string exr = (folder.path() / "a.exr").string();
  REQUIRE(run_lucarium("render builtin:cornell " + constant_technique() + "--iterations 1 -o " + exr).exit_code == 0);
  const nlohmann::json frame = only_frame(run_lucarium("--json render builtin:cornell " + constant_technique() +
                                                       "--iterations 1 --exposure 0 --curve --reference " + exr));
  CHECK(frame["metrics"]["relMSE"] == 0);
}

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

TEST_CASE("options that had nothing to replace, and plans with options of results, are mistakes") {
  check_refused("render builtin:cornell --json --overwrite", 2, "--overwrite does nothing without --output or");
  check_refused("diff a.exr b.exr --overwrite", 2, "--overwrite does nothing without --output");
  check_refused("scene builtin:cornell --overwrite", 2, "--overwrite does nothing without --export or --atlas or");
  check_refused("man render --overwrite", 2, "--overwrite does nothing without --output");
  for (const char* option : {"--gate relMSE<1", "--baseline x", "--link-images", "--resume", "--overwrite"}) {
    const std::string quoted = std::string(option).find('<') == std::string::npos ? option : "--gate 'relMSE<1'";
    check_refused("compare builtin:cornell --dry-run " + quoted, 2, "give --dry-run or --");
  }
}

TEST_CASE("an option of a command before the command's name says where it belongs") {
  check_refused("--size 16x12 render builtin:cornell", 2,
                "--size stands before the command's name; options of render stand behind it: lucarium render … --size");
  check_refused("-q -o a.exr render builtin:cornell", 2, "-o stands before the command's name; options of render");
  check_refused("--spp=3", 2, "--spp stands before the command's name; options of render");
  check_refused("--sppp 3 render builtin:cornell", 2, "unknown option --sppp");
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

TEST_CASE("a camera that is written wrong was looked for by name") {
  check_refused("scene builtin:cornell --camera nan,0,0:0,0,0", 2, "it is not EYE:TARGET or EYE:TARGET:VFOV");
  check_refused("scene builtin:cornell --camera 0,0:1,1", 2, "it is not EYE:TARGET or EYE:TARGET:VFOV");
}

TEST_CASE("values that were taken silently are mistakes") {
  const TemporaryFolder folder;
  const std::string out = " -o " + (folder.path() / "a.exr").string() + " ", render = "render builtin:cornell ";
  check_refused(render + "--seed=-1" + out, 2, "--seed: '-1' is not a whole number from 0 to 18446744073709551615");
  check_refused(render + "--seed=18446744073709551616" + out, 2, "--seed: '18446744073709551616' is not");
  check_refused(render + "--spp 99999999999999999999" + out, 2, "--spp: '99999999999999999999' is not");
  check_refused(render + "--iterations 1e3" + out, 2, "--iterations: '1e3' is not a whole number");
  check_refused("reference builtin:cornell --spp=-1" + out, 2, "--spp: '-1' is not");
  check_refused("compare builtin:cornell -t path_tracing --iterations 18446744073709551616" + out, 2, "--iterations");
  for (const char* value : {"nan", "inf", "-inf", "bright"}) {
    check_refused(render + "--exposure=" + value + out, 2, "a finite number of stops, or auto");
    check_refused(render + "--at=" + value + out, 2, "is not a finite number");
    check_refused(std::string("diff a.exr b.exr --exposure=") + value, 2, "is not a finite number");
  }
  check_refused(render + "--memory-limit 0" + out, 2, "--memory-limit: '0' leaves no memory at all");
  check_refused(render + "--allocation-limit 0G" + out, 2, "--allocation-limit: '0G' leaves no memory at all");
  for (const char* command : {"render builtin:cornell", "compare builtin:cornell", "reference builtin:cornell",
                              "techniques", "check path_tracing", "reproduce"}) {
    check_refused(std::string(command) + " --technique-path /nosuch -o x", 2, "there is no folder '/nosuch'");
  }
  CHECK(count_files(folder.path()) == 0);
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

TEST_CASE("leading zeros are not octal") {
  const nlohmann::json summary =
      only_frame(run_lucarium("render builtin:cornell " + constant_technique() + "--iterations 010 --seed 007 --json"));
  CHECK(summary["iterations"] == 10);
  CHECK(summary["seed"] == 7);
}

TEST_CASE("standard output that cannot be written is an error, not a success") {
  const std::string full = " >/dev/full";
  const std::string message = "cannot write to standard output: No space left on device";
  for (const char* command : {"techniques", "techniques --json", "techniques --markdown", "devices --json",
                              "scene builtin:cornell", "scene builtin:cornell --json", "render --help"}) {
    check_refused(command + full, 3, message);
  }
  check_refused("render builtin:cornell " + constant_technique() + "--iterations 1 --json --quiet" + full, 3, message);
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

TEST_CASE("device: exit code 4") {
  const TemporaryFolder folder;
  const std::string render = "render builtin:cornell -o " + (folder.path() / "a.exr").string() + " ";
  check_refused(render + constant_technique() + "--device quantum", 4, "quantum");
  check_refused(render + constant_technique() + "--memory-limit 1K", 4, "KiB");
  check_refused(render + constant_technique("extra_megabytes=100000000"), 4, "TiB");
  const ProgramResult none = run_program("OCL_ICD_VENDORS=/nonexistent " + lucarium_program() + " devices");
  CHECK(none.exit_code == 4);
  CHECK(contains(none.err, "pocl-opencl-icd"));
  CHECK(count_files(folder.path()) == 0);
}

TEST_CASE("technique: exit code 5, and a failure leaves no file") {
  const TemporaryFolder folder;
  const std::string out = " -o " + (folder.path() / "a.exr").string() + " --iterations 3 ";
  const std::string plugins = environment("LUCARIUM_TEST_PLUGINS");
  check_refused("render builtin:cornell -t wrong_abi --technique-path " + plugins + "/wrong_abi" + out, 5,
                "is built for ABI");
  check_refused("render builtin:cornell -t throws_in_create --technique-path " + plugins + "/throws_in_create" + out, 5,
                "an exception of the plug-in's own");
  check_refused("render builtin:cornell " + constant_technique() + "--max-bounces 7" + out, 5, "at most 3 bounces");
  check_refused("render builtin:cornell " + constant_technique("failure=error,fail_at=2") + out, 5,
                "it fails as requested");
  check_refused("render builtin:cornell " + constant_technique("failure=exception,fail_at=2") + out, 5,
                "an exception that is no Error");
  check_refused("render builtin:cornell " + constant_technique("failure=nan,fail_at=2") + out, 5, "values are NaN");
  CHECK(count_files(folder.path()) == 0);
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

TEST_CASE("a plug-in that cannot be loaded does not stop the others, and says why") {
  const std::string plugins = environment("LUCARIUM_TEST_PLUGINS");
  const ProgramResult result = run_lucarium("techniques --technique-path " + plugins + "/wrong_abi --technique-path " +
                                            plugins + "/text_file --technique-path " + plugins + "/constant");
  CHECK(result.exit_code == 0);
  CHECK(contains(result.out, "constant"));
  CHECK(contains(result.err, "wrong_abi.so: is built for ABI"));
  CHECK(contains(result.err, "text_file.so: cannot be loaded: "));
}
