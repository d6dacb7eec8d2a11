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
  check_refused("render builtin:cornell --bounces 3" + out, 2,
                "unknown option --bounces; did you mean '--max-bounces'?");
  check_refused("scene --export a.glb", 2, "--export does nothing without SCENE");
  check_refused("render", 2, "render needs SCENE: a .gltf or .glb file");
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
  check_refused("diff only-one.exr", 2, "diff needs REFERENCE: reference image");
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

TEST_CASE("an option with nothing behind its sign did nothing") {
  const TemporaryFolder folder;
  const std::string out = " -o " + (folder.path() / "a.exr").string();
  check_refused("render builtin:cornell --profile=" + out, 2,
                "--profile= has no value; write --profile alone, or --profile=FILE");
  check_refused("render builtin:cornell --spp=" + out, 2, "--spp needs a value: N");
  check_refused("compare --comparison= -o " + folder.path().string(), 2, "--comparison needs a value: FILE.json");
}

TEST_CASE("a color of two numbers was looked for as a file") {
  check_refused("scene builtin:cornell --environment 1,2", 2, "environment '1,2': a color is R,G,B or one number");
  check_refused("scene builtin:cornell --environment 1,-1,0*2", 2, "environment '1,-1,0*2': a color is");
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
  for (const char* command : {"render builtin:cornell", "compare builtin:cornell", "reference builtin:cornell -o x.exr",
                              "techniques", "check path_tracing", "reproduce"}) {
    check_refused(std::string(command) + " --technique-path /nosuch", 2, "there is no folder '/nosuch'");
  }
  CHECK(count_files(folder.path()) == 0);
}

TEST_CASE("leading zeros are not octal") {
  const nlohmann::json summary =
      only_frame(run_lucarium("render builtin:cornell " + constant_technique() + "--iterations 010 --seed 007 --json"));
  CHECK(summary["iterations"] == 10);
  CHECK(summary["seed"] == 7);
}

TEST_CASE("the parser's own wordings reached the user") {
  const std::string render = "render builtin:cornell ";
  check_refused("--quiet", 2, "no command is given; `lucarium --help` lists them");
  check_refused("reference builtin:cornell", 2, "reference needs --output FILE.exr: where to write the result");
  check_refused("diff", 2, "diff needs TEST: image under test (see lucarium diff --help)");
  check_refused("diff a.exr b.exr c.exr", 2, "'c.exr' is a word too many: diff takes TEST REFERENCE");
  check_refused(render + "one two", 2, "'one' is a word too many: render takes SCENE");
  check_refused("devices all", 2, "'all' is a word too many: devices takes none");
  check_refused(render + "-o a.png --profile p.json", 2,
                "'p.json' stands behind --profile; its value is written --profile=p.json");
  check_refused("render --profile p.json builtin:cornell -o a.png", 2, "is written --profile=p.json");
  check_refused(render + "--spp", 2, "--spp needs a value: N");
  check_refused(render + "--frames --at 1", 2, "--frames needs a value: FIRST:LAST");
  check_refused(render + "-o --json", 2, "--output needs a value: FILE.exr|.png");
  check_refused(render + "--overwrite=maybe", 2, "--overwrite takes no value");
  check_refused(render + "-Z", 2, "unknown option -Z (see lucarium render --help)");
  check_refused(render + "--max-bounces 9999", 2, "--max-bounces: '9999' is not a whole number from -1 to 4095");
  check_refused(render + "--threads 1.5", 2, "--threads: '1.5' is not a whole number from 0 to 4096");
  check_refused("completion bsh", 2, "SHELL: 'bsh' is none of bash, zsh, fish; did you mean 'bash'?");
  check_refused("diff a b -o m.png --map-of sgned", 2,
                "--map-of: 'sgned' is none of signed, ldr_flip, hdr_flip; did you mean 'signed'?");
}

TEST_CASE("an empty value counted as an option that is not given") {
  const std::string render = "render builtin:cornell -o a.png ";
  check_refused(render + "--load-state ''", 2, "--load-state needs a value: FILE (see lucarium render --help)");
  check_refused(render + "--save-state ''", 2, "--save-state needs a value: FILE");
  check_refused(render + "--frames '' --at 1", 2, "--frames needs a value: FIRST:LAST");
  check_refused(render + "-p ''", 2, "--parameter needs a value: KEY=VALUE");
  check_refused("render builtin:cornell -o ''", 2, "--output needs a value: FILE.exr|.png");
  check_refused("compare --comparison '' -o results", 2, "--comparison needs a value: FILE.json");
  check_refused("scene ''", 2, "'' is an empty word: scene takes SCENE (see lucarium scene --help)");
  check_refused("diff a.exr ''", 2, "'' is an empty word: diff takes TEST REFERENCE");
}

TEST_CASE("names that are nearly right are suggested, whatever they name") {
  const std::string render = "render builtin:cornell -o a.exr ", common = " --iterations 1 -o results";
  check_refused(render + "--material lamp:rouhness=1", 2, "'rouhness' does not exist; did you mean 'roughness'?");
  check_refused(render + "--material lam:roughness=1", 2, "did you mean 'lamp'?");
  check_refused(render + "--camera fron", 2, "there is no camera 'fron'; did you mean 'front'?");
  check_refused(render + "--animation walk", 2, "there is no animation 'walk': it has none");
  check_refused("reference builtin:cornell -o a.exr --path-set dirct=off", 2, "did you mean 'direct'?");
  check_refused("reference builtin:cornell -o a.exr --path-set direct=of", 2, "is not a value of direct: on or off");
  check_refused("compare builtin:cornell -t path_tracing --gate 'relms<1'" + common, 2, "did you mean 'relMSE'?");
  check_refused("techniques path_tracng", 2, "did you mean 'path_tracing'?");
  check_refused("reproduce hermes201 -o results", 2, "did you mean 'hermes2010'?");
  check_refused("reproduce hermes2010/resoluton -o results", 2, "did you mean 'resolution'?");
}
