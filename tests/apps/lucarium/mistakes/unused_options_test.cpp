// SPDX-License-Identifier: Apache-2.0
// Options that would do nothing, or contradict one another: exit code 2, nothing written.
#include "cli_support.h"

using namespace lucarium::test;

TEST_CASE("options that did nothing, and said nothing, are mistakes") {
  const TemporaryFolder folder;
  const std::string exr = " -o " + (folder.path() / "a.exr").string(),
                    png = " -o " + (folder.path() / "a.png").string(),
                    out = " -o " + (folder.path() / "results").string(), render = "render builtin:cornell ";
  check_refused(render + "--fps 12" + exr, 2, "--fps does nothing without --frames");
  check_refused(render + "--relmse 0.1" + exr, 2, "--relmse does nothing without --reference");
  check_refused(render + "--curve --json", 2, "--curve does nothing without --reference");
  check_refused(render + "--curve --reference a.exr --relmse 0.1" + exr, 2, "--curve does nothing without --json");
  check_refused(render + "--half" + png, 2, "--half does nothing without an --output FILE.exr");
  check_refused(render + "--exposure 1" + exr, 2, "--exposure does nothing without an --output FILE.png");
  check_refused(render + "--frames 0:1 --at 1" + exr, 2, "give --frames or --at, not both");
  check_refused(render + "--frames 0:1 --reference a.exr --json" + exr, 2, "give --frames or --reference, not both");

  check_refused(render + "--no-sidecar" + exr, 2, "--no-sidecar does nothing: builtin:cornell has no sidecar");
  check_refused("diff --formulas --max-relmse 0.1", 2, "--max-relmse does nothing without");
  check_refused("diff --formulas --exposure 2", 2, "--exposure does nothing without");
  check_refused("diff --formulas" + png, 2, "--output does nothing without");
  check_refused("reference builtin:cornell -t path_tracing:roulette=off --size 8x8 --spp 32" + exr, 2,
                "roulette=off does nothing here");

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
  for (const char* option : {"--output x", "--overwrite", "--resume", "--dry-run", "--full", "--device 0"})
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

TEST_CASE("options that had nothing to replace, and plans with options of results, are mistakes") {
  check_refused("render builtin:cornell --json --overwrite", 2,
                "--overwrite does nothing without --output, --save-state or");
  check_refused("render builtin:cornell --json --profile --overwrite", 2,
                "without --output, --save-state or --profile=FILE");
  check_refused("scene builtin:cornell --exposure 1", 2, "--exposure does nothing without --export");
  for (const char* option : {"--overwrite", "--resume"})
    check_refused(std::string("reproduce hermes2010 --dry-run ") + option, 2, "give --dry-run or --");
  for (const char* command : {"render builtin:cornell --json", "reference builtin:cornell -o a.exr",
                              "check path_tracing", "scene builtin:cornell --atlas a.png"})
    check_refused(std::string(command) + " --no-cache --cache-dir .", 2, "give --no-cache or --cache-dir, not both");
  check_refused("diff a.exr b.exr --overwrite", 2, "--overwrite does nothing without --output");
  check_refused("scene builtin:cornell --overwrite", 2, "--overwrite does nothing without --export or --atlas or");
  check_refused("man render --overwrite", 2, "--overwrite does nothing without --output");
  for (const char* option : {"--gate relMSE<1", "--baseline x", "--link-images", "--resume", "--overwrite"}) {
    const std::string quoted = std::string(option).find('<') == std::string::npos ? option : "--gate 'relMSE<1'";
    check_refused("compare builtin:cornell --dry-run " + quoted, 2, "give --dry-run or --");
  }
}
