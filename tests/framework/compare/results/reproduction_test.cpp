// SPDX-License-Identifier: Apache-2.0
// What an experiment's values and trends are where pieces ran on machines of several kinds; on results made by hand.
#include "lucarium/compare/results/reproduction.h"

#include <doctest/doctest.h>

#include <cmath>

#include "lucarium/base/json.h"
#include "lucarium/compare/results/comparison_result.h"
#include "tolerance.h"

using namespace lucarium;

namespace {

/// One scene and one variant, whose relMSE is 0.4 / t; a run of 4 s.
ComparisonResult example(const ComparisonBudget& budget) {
  ComparisonResult result;
  result.spec.scenes.resize(1);
  result.spec.variants = {{"a", {}, ""}};
  result.spec.budgets = {budget};
  result.variants.resize(1);
  result.scenes.resize(1);
  PieceResult piece;
  piece.render_summary = R"({"passes": [{"schedule": "first bounce", "name": "gather", "device_seconds": 3},
    {"schedule": "first bounce", "name": "sort rays", "device_seconds": 0.5},
    {"schedule": "later bounces", "name": "gather", "device_seconds": 1}],
    "counters": {"rays": 7}, "warnings": []})";
  piece.iterations = 8;
  piece.iterate_seconds = 4;
  result.pieces.push_back(piece);
  Summary& summary = result.summaries[{0, 0, 0}];
  summary.seeds = 1;
  summary.samples = 8;
  summary.iterate_seconds = 4;
  summary.peak_host_bytes = 100;
  summary.metrics["relMSE"].mean = 0.1;
  summary.reached_seconds.emplace().mean = 2;
  for (const double t : {1.0, 2.0, 4.0}) summary.curve.emplace_back(SummaryPoint{t, t, {}}).relmse.mean = 0.4 / t;
  return result;
}

Reproduction reproduce_with(const ComparisonResult& result, const std::vector<std::string>& expressions,
                            const std::string& trend = "x0 > 0") {
  Experiment experiment;
  experiment.paper = "paper";
  experiment.name = "experiment";
  for (const std::string& expression : expressions) {
    ExperimentValue value;
    value.name = "x" + std::to_string(experiment.values.size());
    value.expression = expression;
    value.variant = expression.find('x') == 0 ? "" : "a";
    experiment.values.push_back(value);
  }
  experiment.trends = {{"it is so", trend}};
  ImagePairs pairs("nowhere");
  return reproduce(experiment, result, pairs);
}

const std::vector<std::string> times = {"seconds",
                                        "iterate_seconds/iterations",
                                        "prepare_seconds",
                                        "device_seconds",
                                        "reached_seconds",
                                        "pass_gather",
                                        "schedule_first_bounce",
                                        "fastest_iterate_seconds",
                                        "fastest_pass_gather",
                                        "fastest_schedule_later_bounces",
                                        "seconds_to(0.2)",
                                        "relmse_at(2)",
                                        "seconds_to(0.2) < 3",
                                        "seconds < 3 ? 1 : 2",
                                        "relmse_at(2) < 3"};

}  // namespace

TEST_CASE("of like machines, times have values and trends a verdict") {
  const ComparisonResult result = example({0, 8, 0, 0});
  for (const std::string& expression : times) {
    CAPTURE(expression);
    CHECK_FALSE(std::isnan(reproduce_with(result, {expression}).values[0].ours));
  }
  const Reproduction found = reproduce_with(result, {"seconds_to(0.2)"});
  CHECK(found.values[0].ours == test::relative(2));
  CHECK(found.trends[0].verdict == "holds");
  CHECK_FALSE(found.trends[0].unlike_machines);
}

TEST_CASE("passes are summed over schedules of one name each, schedules over their passes") {
  const ComparisonResult result = example({0, 8, 0, 0});
  const Reproduction found = reproduce_with(
      result, {"pass_gather", "pass_sort_rays", "schedule_first_bounce", "schedule_later_bounces"}, "x0 > x2");
  CHECK(found.values[0].ours == test::relative(4));
  CHECK(found.values[1].ours == test::relative(0.5));
  CHECK(found.values[2].ours == test::relative(3.5));
  CHECK(found.values[3].ours == test::relative(1));
}

TEST_CASE("of unlike machines, no time has a value, and no trend that uses one a verdict") {
  ComparisonResult result = example({0, 8, 0, 0});
  result.scenes[0].unlike_machines = true;
  for (const std::string& expression : times) {
    CAPTURE(expression);
    // By way of another value, too, whose conditional expression would hide what is not a number.
    for (const char* trend : {"x0 > 0", "x1 > 0", "x1 <= 0"}) {
      const Reproduction found = reproduce_with(result, {expression, "x0 > 0 ? 1 : 0"}, trend);
      CHECK(std::isnan(found.values[0].ours));
      CHECK(std::isnan(found.values[1].ours));
      CHECK(found.trends[0].verdict == "unknown");
      CHECK(found.trends[0].unlike_machines);
      CHECK(found.table().find("unknown, since the machines differ: it is so") != std::string::npos);
    }
  }
  result.reproduction = reproduce_with(result, {"seconds"});
  CHECK(nlohmann::json::parse(result.to_json())["reproduction"]["trends"][0]["unlike_machines"] == true);
}

TEST_CASE("of unlike machines, equal work has values, and equal time has none") {
  for (const bool equal_time : {false, true}) {
    CAPTURE(equal_time);
    ComparisonResult result = example(equal_time ? ComparisonBudget{4, 0, 0, 0} : ComparisonBudget{0, 8, 0, 0});
    result.scenes[0].unlike_machines = true;
    for (const char* expression : {"relMSE", "iterations", "samples", "counter_rays/samples"}) {
      CAPTURE(expression);
      const Reproduction found = reproduce_with(result, {expression});
      CHECK(std::isnan(found.values[0].ours) == equal_time);
      CHECK(found.trends[0].verdict == (equal_time ? "unknown" : "holds"));
      CHECK(found.trends[0].unlike_machines == equal_time);
    }
    const Reproduction found = reproduce_with(result, {"peak_host_bytes + pixels"});
    CHECK(found.trends[0].verdict == "holds");
  }
}

TEST_CASE("what was not measured is unknown, whatever the machines") {
  ComparisonResult result = example({0, 8, 0, 0});
  result.scenes[0].unlike_machines = true;
  const Reproduction found = reproduce_with(result, {"HDR_FLIP"});
  CHECK(found.trends[0].verdict == "unknown");
  CHECK_FALSE(found.trends[0].unlike_machines);
}
