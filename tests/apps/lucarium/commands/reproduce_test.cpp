// SPDX-License-Identifier: Apache-2.0
// lucarium reproduce with a paper of one experiment about the technique `constant`, whose images are known.
#include <fstream>

#include "cli_support.h"
#include "tolerance.h"

using namespace lucarium::test;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

/// 2 shows 0.5 too much everywhere, 1 shows 0.25 too much; the mean square errors are 0.25 and 0.0625.
json known_experiment() {
  return json::parse(R"json({
    "schema": "lucarium-experiment-1",
    "title": "Errors of constants", "place": "Table 3", "claim": "They are known.",
    "comparison": {
      "scenes": ["builtin:furnace"],
      "techniques": [
        {"technique": "constant", 
      "parameters": {"red": 1.25, "green": 1.25, "blue": 1.25}, "name": "near"},
        {"technique": "constant", 
      "parameters": {"red": 1.5, "green": 1.5, "blue": 1.5}, "name": "far"}],
      "budgets": [{"iterations": 1}], "seeds": 1, "size": [16, 8], "max_bounces": 1,
       "reference": {"file": "reference.exr"}
    },
    "quick": {"techniques": [{"technique": "constant", 
      "parameters": {"red": 1.25, "green": 1.25, "blue": 1.25}, "name": "near"}]},
    "values": [
      {"name": "near", "label": "near one", "technique": "near", "value": "sqrt(MSE)", "unit": "cd/m2", "paper": 0.3},
      {"name": "far", "technique": "far", "value": "sqrt(MSE)"},
      {"name": "ratio", "value": "far/near", "paper": 2},
      {"name": "apart", "technique": "far", "against": "near", "value": "MSE"},
      {"name": "differing", "technique": "far", "against": "near", "value": "differing_pixels"},
      {"name": "itself", "technique": "near", "against": "near", "value": "differing_pixels + MSE"}],
    "trends": [
      {"claim": "near is nearer", "holds": "near < far"},
      {"claim": "far is far", "holds": "ratio > 3"},
      {"claim": "near is near", "holds": "near > 0.2 && near < 0.3"}]
  })json");
}

/// A folder with the paper; `experiment` is its only one.
class PaperFolder {
 public:
  explicit PaperFolder(const json& experiment) {
    const fs::path paper = folder_.path() / "experiments" / "author2026";
    fs::create_directories(paper);
    write(paper / "paper.json", {{"schema", "lucarium-paper-1"},
                                 {"citation", "Author 2026"},
                                 {"technique", "constant"},
                                 {"experiments", {"errors"}}});
    write(paper / "errors.json", experiment);
    const ProgramResult made = run_lucarium("render builtin:furnace " + constant_technique("red=1,green=1,blue=1") +
                                            "--iterations 1 -o " + (paper / "reference.exr").string());
    REQUIRE_MESSAGE(made.exit_code == 0, made.err);
  }

  fs::path output() const { return folder_.path() / "out"; }
  std::string arguments(const std::string& more) const {
    return "reproduce " + more + " --technique-path " + environment("LUCARIUM_TEST_PLUGINS") +
           "/constant --technique-path " + folder_.path().string();
  }

 private:
  static void write(const fs::path& file, const json& content) { std::ofstream(file) << content.dump(2); }
  TemporaryFolder folder_;
};

json results_of(const fs::path& folder) { return json::parse(std::ifstream(folder / "errors" / "results.json")); }

}  // namespace

TEST_CASE("papers and experiments are listed") {
  const PaperFolder paper(known_experiment());
  const ProgramResult result = run_lucarium(paper.arguments("--list"));
  CHECK(result.exit_code == 0);
  CHECK(contains(result.out, "author2026/errors  Errors of constants (Table 3)"));
}

TEST_CASE("--list of a paper was refused, and named an option that there is not") {
  const PaperFolder paper(known_experiment());
  for (const char* line : {"author2026 --list", "author2026/errors --list"})
    CHECK(contains(run_lucarium(paper.arguments(line)).out, "author2026/errors  Errors of constants (Table 3)"));
  CHECK_FALSE(contains(run_lucarium(paper.arguments("author2026 --list")).out, "hermes2010"));
  check_refused(paper.arguments("author2027 --list"), 2, "did you mean 'author2026'?");
  check_refused(paper.arguments("author2026/error --list"), 2, "did you mean 'errors'?");
}

TEST_CASE("a plan said nothing while it was made, and runs to be replaced or continued are none of its") {
  const PaperFolder paper(known_experiment());
  const ProgramResult plan = run_lucarium(paper.arguments("author2026 --dry-run"));
  CHECK(plan.exit_code == 0);
  CHECK(contains(plan.err, "author2026/errors: Errors of constants\n"));
  CAPTURE(plan.err);
  CHECK(contains(plan.err, "builtin:furnace: first iterations of "));
  CHECK(run_lucarium(paper.arguments("author2026 --dry-run -q")).err.empty());
  CHECK(json::parse(run_lucarium(paper.arguments("author2026 --dry-run --json")).out)["plans"].size() == 1);
}

TEST_CASE("every experiment that comes with the program can be read") {
  const ProgramResult result = run_lucarium("reproduce --list");
  CHECK_MESSAGE(result.exit_code == 0, result.err);
}

TEST_CASE("values and trends are read off the results") {
  const PaperFolder paper(known_experiment());
  const ProgramResult result = run_lucarium(paper.arguments("author2026 --full -o " + paper.output().string()));
  REQUIRE_MESSAGE(result.exit_code == 0, result.err);
  const json reproduction = results_of(paper.output()).at("reproduction");
  CHECK(reproduction.at("quick") == false);
  const json& values = reproduction.at("values");
  CHECK(values[0].at("ours").get<double>() == lucarium::test::relative(0.25));
  CHECK(values[0].at("paper").get<double>() == lucarium::test::relative(0.3));
  CHECK(values[1].at("ours").get<double>() == lucarium::test::relative(0.5));
  CHECK(!values[1].contains("paper"));
  CHECK(values[2].at("ours").get<double>() == lucarium::test::relative(2));
  const json& trends = reproduction.at("trends");
  CHECK(trends[0].at("verdict") == "holds");
  CHECK(trends[1].at("verdict") == "fails");
  CHECK(trends[2].at("verdict") == "holds");
  CHECK(contains(result.out, "holds: near is nearer"));
  CHECK(contains(result.out, "fails: far is far"));
}

TEST_CASE("images of one technique are measured against those of another") {
  const PaperFolder paper(known_experiment());
  REQUIRE(run_lucarium(paper.arguments("author2026 --full -o " + paper.output().string())).exit_code == 0);
  const json values = results_of(paper.output()).at("reproduction").at("values");
  CHECK(values[3].at("ours").get<double>() == lucarium::test::relative(0.0625));
  CHECK(values[4].at("ours").get<double>() == 1);
  CHECK(values[5].at("ours").get<double>() == 0);
}

TEST_CASE("the quick setting leaves things unknown, and a finished run is only read again") {
  const PaperFolder paper(known_experiment());
  const std::string arguments = paper.arguments("author2026/errors -o " + paper.output().string());
  REQUIRE(run_lucarium(arguments).exit_code == 0);
  const ProgramResult again = run_lucarium(arguments + " --resume");
  CHECK(again.exit_code == 0);
  CHECK(contains(again.err, "finished already: 1 piece"));
  const json reproduction = results_of(paper.output()).at("reproduction");
  CHECK(reproduction.at("quick") == true);
  CHECK(!reproduction.at("values")[1].contains("ours"));
  CHECK(!reproduction.at("values")[3].contains("ours"));
  CHECK(reproduction.at("trends")[0].at("verdict") == "unknown");
  CHECK(reproduction.at("trends")[2].at("verdict") == "holds");
  check_refused(arguments, 2, "already holds results");
}

TEST_CASE("mistakes in experiments name file, line and key") {
  const auto refuse = [](const char* pointer, const json& value, const std::string& part) {
    json experiment = known_experiment();
    experiment[json::json_pointer(pointer)] = value;
    const PaperFolder paper(experiment);
    check_refused(paper.arguments("author2026 --full -o " + paper.output().string()), 3, part);
    CHECK(!fs::exists(paper.output()));
  };
  refuse("/schema", "x", "errors.json:");
  refuse("/values/0/technique", "nearr", "no technique has the label 'nearr'; did you mean 'near'?");
  refuse("/values/3/against", "nearr", "no technique has the label 'nearr'; did you mean 'near'?");
  refuse("/values/2/against", "near", "needs \"technique\"");
  refuse("/values/2/layer", "direct", "values/2/layer: needs \"technique\"");
  refuse("/values/3/layer", "direct", "values/3/layer: needs \"technique\", and no \"against\"");
  refuse("/values/0/value", "sqrt(MSE", "values/0/value");
  refuse("/values/2/name", "far", "'far' is given twice");
  refuse("/values/1/name", "a b", "must be letters");
  refuse("/values/1/scene", 1, "there are 1, numbered from 0");
  refuse("/trends/0/holds", "near < fa", "no value is called 'fa'; did you mean 'far'?");
  refuse("/comparison/seeds", 0, "comparison/seeds");
  refuse("/quick", {{"seds", 1}}, "quick");
}

namespace {

/// Rows that are stated once for several techniques and scenes; the quick setting has one of each.
json experiment_for_each() {
  json experiment = known_experiment();
  experiment["values"] = json::parse(R"json([
    {"each": {"scene": "all", "technique": ["near", "far"]}, "name": "mse_{scene}_{technique}",
     "label": "{scene}: MSE of {technique}", "unit": "of {technique}", "value": "MSE"},
    {"each": {"scene": ["builtin:furnace"]}, "name": "ratio_{scene}",
     "value": "mse_{scene}_far/mse_{scene}_near"}])json");
  experiment["plots"] = json::parse(R"json([
    {"name": "grow", "title": "Errors", "x": "pixels", "y": "MSE", "x_label": "pixels", "y_label": "MSE"}])json");
  experiment["trends"] = json::parse(R"json([
    {"each": {"scene": "all"}, "claim": "{scene}: near is nearer", "holds": "ratio_{scene} > 1"},
    {"each": {"technique": ["near", "far"]}, "claim": "{technique} is off",
     "holds": "mse_builtin_furnace_{technique} > 0"},
    {"claim": "errors do not grow", "holds": "abs(grow_near) < 1"}])json");
  return experiment;
}

}  // namespace

TEST_CASE("values and trends are stated once for each scene and technique") {
  const PaperFolder paper(experiment_for_each());
  REQUIRE(run_lucarium(paper.arguments("author2026 --full -o " + paper.output().string())).exit_code == 0);
  const json reproduction = results_of(paper.output()).at("reproduction");
  const json& values = reproduction.at("values");
  REQUIRE(values.size() == 3);
  CHECK(values[0].at("label") == "builtin:furnace: MSE of near");
  CHECK(values[0].at("ours").get<double>() == lucarium::test::relative(0.0625));
  CHECK(values[1].at("label") == "builtin:furnace: MSE of far");
  CHECK(values[1].at("unit") == "of far");
  CHECK(values[1].at("ours").get<double>() == lucarium::test::relative(0.25));
  CHECK(values[2].at("ours").get<double>() == lucarium::test::relative(4));
  const json& trends = reproduction.at("trends");
  REQUIRE(trends.size() == 4);
  CHECK(trends[0].at("claim") == "builtin:furnace: near is nearer");
  for (size_t i = 0; i < 3; ++i) CHECK(trends[i].at("verdict") == "holds");
  CHECK(trends[3].at("verdict") == "unknown");  // one scene has no slope
  const json& lines = reproduction.at("plots").at(0).at("lines");
  CHECK(lines[1].at("label") == "far");
  CHECK(lines[1].at("points").at(0).at("x").get<double>() == 128);
  CHECK(lines[1].at("points").at(0).at("y").get<double>() == lucarium::test::relative(0.25));
  CHECK_FALSE(lines[1].contains("slope"));
}

TEST_CASE("rows for what the quick setting leaves out are left out") {
  const PaperFolder paper(experiment_for_each());
  REQUIRE(run_lucarium(paper.arguments("author2026 -o " + paper.output().string())).exit_code == 0);
  const json reproduction = results_of(paper.output()).at("reproduction");
  REQUIRE(reproduction.at("values").size() == 2);
  CHECK(reproduction.at("values")[0].at("label") == "builtin:furnace: MSE of near");
  CHECK_FALSE(reproduction.at("values")[1].contains("ours"));  // far is not there
  REQUIRE(reproduction.at("trends").size() == 3);
  CHECK(reproduction.at("trends")[0].at("verdict") == "unknown");
  CHECK(reproduction.at("trends")[1].at("claim") == "near is off");
}

TEST_CASE("mistakes in rows for each scene name file, line and key") {
  const auto refuse = [](const char* pointer, const json& value, const std::string& part) {
    json experiment = experiment_for_each();
    experiment[json::json_pointer(pointer)] = value;
    const PaperFolder paper(experiment);
    check_refused(paper.arguments("author2026 --full -o " + paper.output().string()), 3, part);
  };
  refuse("/values/0/each/technique/1", "fra", "no technique has the label 'fra'; did you mean 'far'?");
  refuse("/values/0/each/budget", "some", "values/0/each/budget: must be \"all\" or an array of labels");
  refuse("/values/0/each/budgets", "all", "did you mean 'budget'?");
  refuse("/values/0/technique", "near", "values/0/technique: stands in \"each\", too");
  refuse("/values/1/label", "{technique}", "values/1/label: {technique} has no list in \"each\"");
  refuse("/values/0/name", "mse_{scene}", "'mse_builtin_furnace' is given twice");
  refuse("/values/1/scene", "builtin:furnice", "values/1/scene: stands in");
  refuse("/values/1/budget", "2 iterations", "no budget has the label '2 iterations'");
  refuse("/plots/0/scenes", json::array({"x"}), "no scene has the label 'x'");
  refuse("/plots/0/techniques", 3, "plots/0/techniques: must be \"all\"");
  refuse("/plots/0/y", "MSE +", "plots/0/y");
  refuse("/plots/0/name", "1", "plots/0/name: must be letters");
  refuse("/trends/0/holds", "ratio_{scene}s > 1", "no value is called 'ratio_builtin_furnaces'");
}

TEST_CASE("experiments of no paper compare techniques for their own sake") {
  const ProgramResult result = run_lucarium("reproduce lucarium --list");
  CHECK(contains(result.out, "lucarium  (of no paper)"));
  CHECK(contains(result.out, "lucarium/equal_time "));
  const json listed = json::parse(run_lucarium("reproduce lucarium --list --json").out);
  CHECK_FALSE(listed.at("papers").at(0).contains("technique"));
}

TEST_CASE("papers and experiments that are not there") {
  const PaperFolder paper(known_experiment());
  check_refused(paper.arguments("author2025 -o x"), 2, "no paper is called 'author2025'; did you mean 'author2026'?");
  check_refused(paper.arguments("author2026/error -o x"), 2, "did you mean 'errors'?");
  check_refused(paper.arguments("author2026"), 2, "add --output FOLDER");
  check_refused(paper.arguments("-o x"), 2, "which paper?");
}
