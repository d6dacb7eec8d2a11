// SPDX-License-Identifier: Apache-2.0
// lucarium compare as people use it: what it writes, that it refuses to overwrite, and that a killed one goes on.
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include "cli_support.h"

using namespace lucarium::test;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// The pieces that are finished: their summary is there.
std::map<std::string, std::string> finished_pieces(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder / "pieces")) {
    if (entry.path().extension() != ".json") continue;
    for (const char* extension : {".json", ".exr"}) {
      const fs::path file = fs::path(entry.path()).replace_extension(extension);
      files[file.filename().string()] = text_of(file);
    }
  }
  return files;
}

/// Arguments of a comparison of two colours with a third, which is the reference.
std::string comparison(const TemporaryFolder& folder, const std::string& more) {
  const std::string reference = (folder.path() / "reference.exr").string();
  if (!fs::exists(reference)) {
    REQUIRE(run_lucarium("render builtin:cornell " + constant_technique("red=0.3") + "--iterations 1 -o " + reference).exit_code == 0);
  }
  return "compare builtin:cornell " + constant_technique("red=0.25") + "-p sleep=30 -t constant:red=0.35,sleep=30 " +
         "--iterations 5 --seeds 2 --reference " + reference + " -o " + (folder.path() / "results").string() + " " + more;
}

}  // namespace

TEST_CASE("a comparison writes results that parse, a table and a page") {
  const TemporaryFolder folder;
  const fs::path results = folder.path() / "results";
  const ProgramResult run = run_lucarium(comparison(folder, "--json --quiet"));
  CAPTURE(run.err);
  REQUIRE(run.exit_code == 0);
  const json all = json::parse(text_of(results / "results.json"));
  CHECK(json::parse(run.out) == all);
  REQUIRE(all["pieces"].size() == 4);
  for (const json& piece : all["pieces"]) {
    // Only red differs, by .05: MSE = .0025 / 3.
    CHECK(piece["rmse"].get<double>() == doctest::Approx(std::sqrt(0.0025 / 3)).epsilon(1e-4));
    CHECK(piece["samples"] == 5);
    CHECK(fs::exists(results / piece["image"].get<std::string>()));
  }
  CHECK(contains(text_of(results / "results.csv"), "rmse"));
  CHECK(contains(text_of(results / "report.html"), "<html"));
  const std::string before = text_of(results / "results.json");
  check_refused(comparison(folder, ""), 2, "--resume");
  CHECK(text_of(results / "results.json") == before);
  check_refused(comparison(folder, "--resume --max-bounces 2"), 2, "another comparison");
  CHECK(run_lucarium("report " + results.string()).exit_code == 0);
}

TEST_CASE("a comparison that was killed goes on where it stopped; what was finished stays byte for byte") {
  const TemporaryFolder folder;
  const fs::path results = folder.path() / "results";
  const std::string first = (results / "pieces" / "scene1-variant1-seed1.json").string();
  const ProgramResult killed =
      run_program(lucarium_program() + " " + comparison(folder, "--quiet") + " & pid=$!; until [ -e " + first +
                  " ]; do kill -0 $pid || exit 99; sleep 0.02; done; kill -KILL $pid; wait $pid");
  CHECK(killed.exit_code == 137);
  const auto before = finished_pieces(results);
  CHECK(before.size() >= 2);
  CHECK(before.size() < 8);
  REQUIRE(run_lucarium(comparison(folder, "--resume --quiet")).exit_code == 0);
  const auto after = finished_pieces(results);
  CHECK(after.size() == 8);
  for (const auto& [name, bytes] : before) CHECK_MESSAGE(after.at(name) == bytes, name);
  CHECK(json::parse(text_of(results / "results.json"))["pieces"].size() == 4);
}

TEST_CASE("mistakes of a comparison end it before anything is rendered") {
  const TemporaryFolder folder;
  const std::string out = "-o " + (folder.path() / "results").string() + " ";
  check_refused("compare builtin:cornell --iterations 1 " + out, 2, "-t");
  check_refused("compare builtin:cornell " + constant_technique() + out, 2, "--time SECONDS or --iterations N");
  check_refused("compare builtin:cornell " + constant_technique() + "-t constant --iterations 1 " + out, 2, "given twice");
  check_refused("compare builtin:cornell " + constant_technique("rde=1") + "--iterations 1 " + out, 2, "did you mean 'red'?");
  check_refused("compare builtin:cornell -t nonesuch --iterations 1 " + out, 5, "nonesuch");
  check_refused("compare /nonexistent.glb " + constant_technique() + "--iterations 1 " + out, 3, "/nonexistent.glb");
  // None of them stands in the way of the corrected command.
  CHECK_FALSE(fs::exists(folder.path() / "results" / "comparison.json"));
}
