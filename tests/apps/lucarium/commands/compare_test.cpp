// SPDX-License-Identifier: Apache-2.0
// lucarium compare as people use it: what it writes, that it refuses to overwrite, and that a killed one goes on.
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include "cli_support.h"
#include "file_bytes.h"
#include "tolerance.h"

using namespace lucarium::test;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

/// The pieces that are finished: their summary is there.
std::map<std::string, std::string> finished_pieces(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder / "pieces")) {
    if (entry.path().extension() != ".json") continue;
    for (const char* extension : {".json", ".exr"}) {
      const fs::path file = fs::path(entry.path()).replace_extension(extension);
      files[file.filename().string()] = bytes_of(file);
    }
  }
  return files;
}

/// Running processes with this text in their arguments.
size_t count_processes(const std::string& text) {
  size_t count = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator("/proc")) {
    count += contains(bytes_of(entry.path() / "cmdline"), text);
  }
  return count;
}

/// Arguments of a comparison of two colours with a third, which is the reference.
std::string comparison(const TemporaryFolder& folder, const std::string& more) {
  const std::string reference = (folder.path() / "reference.exr").string();
  if (!fs::exists(reference)) {
    REQUIRE(run_lucarium("render builtin:cornell " + constant_technique("red=0.3") + "--iterations 1 -o " + reference)
                .exit_code == 0);
  }
  return "compare builtin:cornell " + constant_technique("red=0.25") + "-p sleep=30 -t constant:red=0.35,sleep=30 " +
         "--iterations 5 --seeds 2 --reference " + reference + " -o " + (folder.path() / "results").string() + " " +
         more;
}

}  // namespace

TEST_CASE("compare -v said nothing of what its renderings do") {
  const TemporaryFolder folder;
  const ProgramResult plain = run_lucarium(comparison(folder, "")),
                      told = run_lucarium(comparison(folder, "--overwrite -v"));
  REQUIRE(told.exit_code == 0);
  CHECK_FALSE(contains(plain.err, "prepared: upload"));
  for (const char* part : {"scene builtin:cornell: 42 triangles", "technique constant", "prepared: upload",
                           "ended by --iterations after 5 iterations"})
    CHECK_MESSAGE(contains(told.err, part), part << told.err);
}

TEST_CASE("a comparison writes results that parse, a table and a page") {
  const TemporaryFolder folder;
  const fs::path results = folder.path() / "results";
  const ProgramResult run = run_lucarium(comparison(folder, "--json --quiet"));
  CAPTURE(run.err);
  REQUIRE(run.exit_code == 0);
  const json all = json::parse(bytes_of(results / "results.json"));
  CHECK(json::parse(run.out) == all);
  REQUIRE(all["pieces"].size() == 4);
  for (const json& piece : all["pieces"]) {
    // Only red differs, by .05: MSE = .0025 / 3.
    CHECK(piece["metrics"]["RMSE"].get<double>() == lucarium::test::relative(std::sqrt(0.0025 / 3), 1e-4));
    CHECK(piece["samples"] == 5);
    CHECK(fs::exists(results / piece["image"].get<std::string>()));
  }
  CHECK(contains(bytes_of(results / "results.csv"), "RMSE"));
  CHECK(contains(bytes_of(results / "report.html"), "<html"));
  const std::string before = bytes_of(results / "results.json");
  check_refused(comparison(folder, ""), 2, "--resume");
  CHECK(bytes_of(results / "results.json") == before);
  check_refused(comparison(folder, "--resume --max-bounces 2"), 2, "holds a different comparison");
  CHECK(run_lucarium("report " + results.string()).exit_code == 0);
}

TEST_CASE("a user's own files in the folder of the results were deleted") {
  const TemporaryFolder folder;
  const fs::path results = folder.path() / "results";
  comparison(folder, "");  // makes the reference
  fs::create_directories(results / "references");
  const auto write = [](const fs::path& file, const std::string& text) { std::ofstream(file) << text; };
  write(results / "references" / "mine.exr", "precious");
  write(results / "notes.txt", "mine");
  for (const char* option : {"", "--overwrite", "--resume"}) {
    check_refused(comparison(folder, option), 2, "references exists, but no comparison wrote it");
  }
  CHECK_FALSE(fs::exists(results / ".lock"));  // which a refused command left behind
  // A comparison file that a person wrote is no result either, whatever its name.
  fs::rename(results / "references", folder.path() / "kept");
  const std::string by_hand = "// my study\n{\"schema\": \"lucarium-comparison-1\"}\n";
  write(results / "comparison.json", by_hand);
  check_refused(comparison(folder, "--overwrite"), 2, "comparison.json exists, but no comparison wrote it");
  CHECK(bytes_of(results / "comparison.json") == by_hand);
  fs::remove(results / "comparison.json");
  fs::rename(folder.path() / "kept", results / "references");

  // What a comparison wrote is replaced when that is asked for, and only that.
  const std::string mine = bytes_of(results / "references" / "mine.exr");
  fs::rename(results / "references", folder.path() / "kept");
  REQUIRE(run_lucarium(comparison(folder, "--quiet")).exit_code == 0);
  fs::rename(folder.path() / "kept" / "mine.exr", results / "references" / "mine.exr");
  write(results / "pieces" / "scene9-variant1-budget1-seed1.json", "of an older comparison");
  REQUIRE(run_lucarium(comparison(folder, "--quiet --overwrite --seeds 1")).exit_code == 0);
  CHECK(bytes_of(results / "references" / "mine.exr") == mine);
  CHECK(bytes_of(results / "notes.txt") == "mine");
  CHECK_FALSE(fs::exists(results / "pieces" / "scene9-variant1-budget1-seed1.json"));
  CHECK(json::parse(bytes_of(results / "comparison.json"))["seeds"] == 1);
}

TEST_CASE("--dry-run did not notice that the reference is missing") {
  const TemporaryFolder folder;
  const std::string missing = (folder.path() / "none.exr").string();
  check_refused("compare builtin:cornell " + constant_technique() + "--iterations 1 --dry-run --reference " + missing,
                3, "none.exr: no such file");
  std::ofstream(folder.path() / "my.json")
      << R"({"schema": "lucarium-comparison-1", "scenes": ["builtin:cornell"], "techniques": ["constant"],
             "budgets": [{"iterations": 1}], "max_bounces": 1, "reference": {"file": "none.exr"}})";
  const std::string plugins = "--technique-path " + environment("LUCARIUM_TEST_PLUGINS") + "/constant ";
  check_refused("compare --dry-run " + plugins + "--comparison " + (folder.path() / "my.json").string(), 3,
                "none.exr: no such file");
}

TEST_CASE("an optional scene without a file is left out, another one is missed") {
  const TemporaryFolder folder;
  const auto run = [&](const std::string& optional, const std::string& output) {
    std::ofstream(folder.path() / "my.json")
        << R"({"schema": "lucarium-comparison-1", "scenes": ["builtin:furnace", {"scene": "none.glb", "optional": )" +
               optional + R"(}], "techniques": ["constant"], "budgets": [{"iterations": 1}], "seeds": 1,
             "size": [8, 8], "max_bounces": 0, "reference": {"samples": 32}})";
    return run_lucarium("compare --technique-path " + environment("LUCARIUM_TEST_PLUGINS") + "/constant --comparison " +
                        (folder.path() / "my.json").string() + " -o " + (folder.path() / output).string());
  };
  const ProgramResult fine = run("true", "fine"), missed = run("false", "missed");
  CHECK_MESSAGE(fine.exit_code == 0, fine.err);
  CHECK(contains(fine.err, "left out: there is no file"));
  CHECK(missed.exit_code == 1);
  CHECK(contains(missed.err, "none.glb"));
  CHECK(json::parse(bytes_of(folder.path() / "fine" / "results.json"))["pieces"].size() == 1);
}

TEST_CASE("--resume and --overwrite together were accepted") {
  const TemporaryFolder folder;
  check_refused(comparison(folder, "--resume --overwrite"), 2, "give --resume or --overwrite, not both");
  check_refused("reproduce paper --resume --overwrite", 2, "give --resume or --overwrite, not both");
  CHECK_FALSE(fs::exists(folder.path() / "results"));
}

TEST_CASE("a comparison that was killed goes on where it stopped; what was finished stays byte for byte") {
  const TemporaryFolder folder;
  const fs::path results = folder.path() / "results";
  const std::string first = (results / "pieces" / "scene1-variant1-budget1-seed1.json").string();
  const ProgramResult killed =
      run_program(lucarium_program() + " " + comparison(folder, "--quiet") + " & pid=$!; until [ -e " + first +
                  " ]; do kill -0 $pid || exit 99; sleep 0.02; done; kill -KILL $pid; wait $pid");
  CHECK(killed.exit_code == 137);
  const auto before = finished_pieces(results);
  CHECK(before.size() >= 2);
  CHECK(before.size() < 8);
  // Nobody goes on rendering: the run in progress ends with the comparison, as soon as the machine lets it.
  CHECK(wait_until([&] { return count_processes((results / "pieces").string()) == 0; }));
  REQUIRE(run_lucarium(comparison(folder, "--resume --quiet")).exit_code == 0);
  const auto after = finished_pieces(results);
  CHECK(after.size() == 8);
  for (const auto& [name, bytes] : before) CHECK_MESSAGE(after.at(name) == bytes, name);
  CHECK(json::parse(bytes_of(results / "results.json"))["pieces"].size() == 4);
}

TEST_CASE("a picture whose budget ended too early has a warning beside its error") {
  const TemporaryFolder folder;
  const fs::path results = folder.path() / "results";
  const ProgramResult run = run_lucarium(
      "compare builtin:cornell -t bundle_exchange:texels=2048 --size 16x16 --max-bounces 1 --iterations 1 --seeds 1 " +
      std::string("--reference-spp 32 -o ") + results.string());
  CHECK(run.exit_code == 0);
  CHECK(contains(run.out + run.err, "unfinished: light is missing"));
  const json warnings = json::parse(bytes_of(results / "results.json"))["scenes"][0]["warnings"];
  REQUIRE(warnings.size() == 1);
  CHECK(contains(warnings[0].get<std::string>(), "the budget ended too early"));
}

TEST_CASE("one exposure is chosen for all pictures of a scene, by the reference") {
  const TemporaryFolder folder;
  const fs::path results = folder.path() / "results", reference = folder.path() / "reference.exr";
  const std::string bright = "red=64,green=32,blue=32";
  REQUIRE(run_lucarium("render builtin:cornell " + constant_technique(bright) + "--iterations 1 --quiet -o " +
                       reference.string())
              .exit_code == 0);
  const std::string common = "compare builtin:cornell " + constant_technique("red=1") +
                             "--iterations 1 --seeds 1 --quiet --json --reference " + reference.string() + " -o ";
  const json chosen = json::parse(run_lucarium(common + results.string()).out);
  CHECK(chosen["scenes"][0]["exposure_stops"] == -6);
  // PSNR is that of the pictures which are shown: the technique's own are black at this exposure.
  const json stated = json::parse(run_lucarium(common + (folder.path() / "x").string() + " --exposure=-6").out);
  CHECK(stated["scenes"][0]["exposure_stops"] == -6);
  CHECK(stated["pieces"][0]["metrics"]["PSNR"] == chosen["pieces"][0]["metrics"]["PSNR"]);
  const json plain = json::parse(run_lucarium(common + (folder.path() / "y").string() + " --exposure 0").out);
  CHECK(plain["pieces"][0]["metrics"]["PSNR"] != chosen["pieces"][0]["metrics"]["PSNR"]);
}

TEST_CASE("mistakes of a comparison end it before anything is rendered") {
  const TemporaryFolder folder;
  const std::string out = "-o " + (folder.path() / "results").string() + " ";
  check_refused("compare builtin:cornell --iterations 1 " + out, 2, "-t");
  check_refused("compare builtin:cornell " + constant_technique() + out, 2,
                "--time SECONDS, --spp N, --iterations N or --relmse E");
  check_refused("compare builtin:cornell " + constant_technique() + "-t constant --iterations 1 " + out, 2,
                "given twice");
  check_refused("compare builtin:cornell " + constant_technique("rde=1") + "--iterations 1 " + out, 2,
                "did you mean 'red'?");
  check_refused("compare builtin:cornell -t nonesuch --iterations 1 " + out, 2, "nonesuch");
  check_refused("compare /nonexistent.glb " + constant_technique() + "--iterations 1 " + out, 3, "/nonexistent.glb");
  // None of them leaves anything that would stand in the way of the corrected command.
  CHECK_FALSE(fs::exists(folder.path() / "results"));
}

TEST_CASE("a timed piece is reproduced by its iterations, and an error budget says when it was reached") {
  const TemporaryFolder folder;
  const fs::path results = folder.path() / "results", again = folder.path() / "again.exr";
  const std::string common = "--size 24x16 --max-bounces 1 ";
  REQUIRE(run_lucarium("compare builtin:cornell -t path_tracing " + common +
                       "--time 0.3 --relmse 0.5 --limit 20 --seeds 1 " + "--reference-spp 64 --quiet -o " +
                       results.string())
              .exit_code == 0);
  const json all = json::parse(bytes_of(results / "results.json"));
  REQUIRE(all["pieces"].size() == 2);
  const json& timed = all["pieces"][0];
  CHECK(timed["snapshots"].size() >= 2);
  CHECK(timed["iterate_seconds"].get<double>() + timed["prepare_seconds"].get<double>() >= 0.3);
  REQUIRE(run_lucarium("render builtin:cornell -t path_tracing " + common + "--seed 1 --quiet --iterations " +
                       std::to_string(timed["iterations"].get<uint64_t>()) + " -o " + again.string())
              .exit_code == 0);
  const ProgramResult difference =
      run_lucarium("diff " + (results / timed["image"].get<std::string>()).string() + " " + again.string() + " --json");
  REQUIRE(difference.exit_code == 0);
  CHECK(contains(difference.out, "\"MSE\": 0.0"));
  CHECK(all["pieces"][1]["reached_seconds"].get<double>() > 0);
}

TEST_CASE("equal samples: every run ends at the samples that were asked for") {
  const TemporaryFolder folder;
  const fs::path results = folder.path() / "results";
  comparison(folder, "");  // makes the reference
  const std::string common = "compare builtin:cornell " + constant_technique() +
                             "-t constant:red=0.5 --spp 3 --spp 7 " + "--seeds 1 --reference " +
                             (folder.path() / "reference.exr").string();
  CHECK(contains(run_lucarium(common + " --dry-run").out, "3 spp; 7 spp at "));
  const ProgramResult run = run_lucarium(common + " -o " + results.string() + " --json");
  CAPTURE(run.err);
  REQUIRE(run.exit_code == 0);
  const json all = json::parse(run.out);
  CHECK(all["comparison"]["budgets"] == json::parse(R"([{"samples": 3}, {"samples": 7}])"));
  REQUIRE(all["pieces"].size() == 4);
  for (const json& piece : all["pieces"]) CHECK(piece["samples"] == (piece["budget"] == 0 ? 3 : 7));
  // After 1, 2, 3, … samples: at times a half octave apart, rounded up.
  CHECK(all["pieces"][2]["snapshots"].size() >= 3);
}

TEST_CASE(
    "variants with different light paths are measured against references of their own; a refused one stands in the "
    "table") {
  const TemporaryFolder folder;
  const fs::path results = folder.path() / "results";
  const std::string command = "compare builtin:cornell -t path_tracing -t path_tracing:direct=off " +
                              constant_technique() +
                              "-t path_tracing:blend=off --pixel-sampling 4 --iterations 2 --seeds 1 " +
                              "--reference-spp 32 -o " + results.string();
  const ProgramResult run = run_lucarium(command + " --quiet");
  CAPTURE(run.err);
  REQUIRE(run.exit_code == 0);
  const json scene = json::parse(bytes_of(results / "results.json"))["scenes"][0];
  REQUIRE(scene["references"].size() == 2);
  CHECK(scene["variants"][0]["reference"] == 0);
  CHECK(scene["variants"][1]["reference"] == 1);
  CHECK(contains(scene["references"][1]["path_set"].get<std::string>(), "direct=off"));
  CHECK(contains(scene["variants"][2]["refused"].get<std::string>(), "cannot sample pixels in mode 4"));
  CHECK(scene["variants"][3]["reference"] == 0);  // nothing is BLEND there: the same light
  // A piece that names the light paths in another way than its reference was taken for one of another scene.
  CHECK(contains(run_lucarium(command + " --resume").err, "finished already: 3 pieces"));
}

TEST_CASE("an interrupt of the comparison alone ends its run too, and keeps what is finished") {
  const TemporaryFolder folder;
  const fs::path results = folder.path() / "results";
  const ProgramResult run =
      run_program(lucarium_program() + " compare builtin:cornell -t path_tracing --size 64x48 --time 60 --seeds 1 " +
                      "--reference-spp 32 --quiet -o " + results.string() + " & pid=$!; until [ -e " +
                      (results / "references/scene1-set1.exr").string() +
                      " ]; do kill -0 $pid || exit 99; sleep 0.05; done; sleep 0.5; kill -INT $pid; wait $pid",
                  50);
  CHECK(run.exit_code == 6);
  CHECK(json::parse(bytes_of(results / "results.json"))["interrupted"] == true);
  CHECK(wait_until([&] { return count_processes((results / "pieces").string()) == 0; }));
}

TEST_CASE("a reference file that shows other light paths, or another scene, is refused") {
  const TemporaryFolder folder;
  const std::string reference = (folder.path() / "r.exr").string(),
                    out = " --seeds 1 --iterations 1 -o " + (folder.path() / "x").string();
  REQUIRE(run_lucarium("reference builtin:cornell --size 16x12 --max-bounces 1 --spp 32 --quiet -o " + reference)
              .exit_code == 0);
  const std::string common = " -t path_tracing --size 16x12 --reference " + reference + out;
  check_refused("compare builtin:cornell --max-bounces 2 --quiet" + common, 2, "max_bounces: 1 against 2");
  check_refused("compare builtin:room --max-bounces 1 --quiet" + common, 2, "shows another scene");
  CHECK_FALSE(fs::exists(folder.path() / "x"));
  CHECK(run_lucarium("compare builtin:cornell --max-bounces 1 --quiet" + common).exit_code == 0);
}

TEST_CASE("a plan reckons with the end that a technique has of its own, not with the cap of its iterations") {
  const TemporaryFolder folder;
  const std::string common = "compare builtin:cornell " + constant_technique("sleep=50,converge_at=20") +
                             "--seeds 1 --dry-run -o " + (folder.path() / "x").string() + " --reference-spp 32";
  for (const char* budget : {" --iterations 1000000", " --time 3600"}) {
    const ProgramResult plan = run_lucarium(common + budget);
    REQUIRE_MESSAGE(plan.exit_code == 0, plan.err);
    CHECK(contains(plan.out, "until it ends by itself"));
    CHECK(contains(plan.out, "about 0:"));
    CHECK(contains(plan.out, " at most\n"));
  }
}

TEST_CASE("a plan is printed and nothing is written; gates set the exit code; a file defines a comparison") {
  const TemporaryFolder folder;
  const fs::path results = folder.path() / "results";
  const ProgramResult plan = run_lucarium(comparison(folder, "--dry-run"));
  CHECK(plan.exit_code == 0);
  CHECK(contains(plan.out, "4 runs"));
  CHECK(contains(plan.out, "of device memory"));
  CHECK(contains(plan.err, "builtin:cornell: planning\n"));
  CAPTURE(plan.err);
  CHECK(contains(plan.err, "builtin:cornell: first iterations of constant:red=0.25"));
  const ProgramResult machine = run_lucarium(comparison(folder, "--dry-run --json"));
  CHECK(json::parse(machine.out)["schema"] == "lucarium-plan-1");
  CHECK_FALSE(fs::exists(results));
  CHECK(run_lucarium(comparison(folder, "--quiet --gate 'rmse<0.1'")).exit_code == 0);
  const ProgramResult missed = run_lucarium(comparison(folder, "--resume --quiet --gate 'rmse<0.01'"));
  CHECK(missed.exit_code == 1);
  CHECK(contains(missed.err, "gate rmse<0.01 missed: 0.02887"));
  const std::string plugins = "--technique-path " + environment("LUCARIUM_TEST_PLUGINS") + "/constant ";
  CHECK(run_lucarium("compare --comparison " + (results / "comparison.json").string() + " --quiet --baseline " +
                     results.string() + " -o " + (folder.path() / "second").string() + " " + plugins)
            .exit_code == 0);
  const json second = json::parse(bytes_of(folder.path() / "second" / "results.json"));
  REQUIRE(second["baseline"]["changes"].size() >= 2);
  CHECK(second["baseline"]["changes"][0]["ratio"].get<double>() == lucarium::test::relative(1));
}
