// SPDX-License-Identifier: Apache-2.0
// Words that the grammar refuses: exit code 2, and one line with the nearest name.
#include "cli_support.h"

using namespace lucarium::test;

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

TEST_CASE("an option of a command before the command's name says where it belongs") {
  check_refused("--size 16x12 render builtin:cornell", 2,
                "--size stands before the command's name; options of render stand behind it: lucarium render … --size");
  check_refused("-q -o a.exr render builtin:cornell", 2, "-o stands before the command's name; options of render");
  check_refused("--spp=3", 2, "--spp stands before the command's name; options of render");
  check_refused("--sppp 3 render builtin:cornell", 2, "unknown option --sppp");
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

TEST_CASE("leading zeros are not octal") {
  const nlohmann::json summary =
      only_frame(run_lucarium("render builtin:cornell " + constant_technique() + "--iterations 010 --seed 007 --json"));
  CHECK(summary["iterations"] == 10);
  CHECK(summary["seed"] == 7);
}
