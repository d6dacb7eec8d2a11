// SPDX-License-Identifier: Apache-2.0
// What an experiment's values and trends are where pieces ran on machines of several kinds; on results made by hand.
#include "lucarium/compare/results/reproduction.h"

#include <doctest/doctest.h>

#include <cmath>

#include "lucarium/base/json.h"
#include "lucarium/compare/results/comparison_result.h"
#include "lucarium/film/image_io.h"
#include "test_support.h"
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

TEST_CASE("slopes are those of power laws") {
  CHECK(loglog_slope({{1, 2}, {10, 20}, {100, 200}}) == test::relative(1));
  CHECK(loglog_slope({{4, 3}, {16, 1.5}}) == test::relative(-0.5));
  // Least squares over log2: the points (0, 0), (1, 1), (2, 0) lie about a level line.
  CHECK(std::abs(loglog_slope({{1, 1}, {2, 2}, {4, 1}})) < 1e-12);
  CHECK(std::isnan(loglog_slope({{1, 2}})));
  CHECK(std::isnan(loglog_slope({{3, 2}, {3, 4}})));
  CHECK(std::isnan(loglog_slope({{1, 2}, {10, 0}})));
}

namespace {

/// Two scenes of 100 and 400 triangles, in which `a` takes 4 and 8 seconds.
ComparisonResult two_scenes() {
  ComparisonResult result = example({0, 8, 0, 0});
  result.spec.scenes.resize(2);
  result.scenes.resize(2);
  result.spec.scenes[1].size = {20, 10};
  result.spec.scenes[1].max_bounces = 5;
  result.spec.scenes[1].threads = 3;
  result.scenes[0].triangles = 100;
  result.scenes[1].triangles = 400;
  result.scenes[1].emissive_triangles = 7;
  result.pieces.push_back(result.pieces.front());
  result.pieces.back().scene = 1;
  Summary summary = result.summaries.at({0, 0, 0});
  summary.iterate_seconds = 8;
  summary.processor_seconds = 16;
  result.summaries[{1, 0, 0}] = summary;
  return result;
}

Experiment with_plot(const std::string& y) {
  Experiment experiment;
  ExperimentPlot plot;
  plot.name = "cost";
  plot.title = "Cost";
  plot.x_label = "triangles";
  plot.y_label = "time [s]";
  plot.x = "triangles";
  plot.y = y;
  plot.variants = {"a", "b"};
  plot.scenes = {0, 1};
  experiment.plots = {plot};
  experiment.trends = {{"it is the root", "abs(cost_a - 0.5) < 1e-9"}, {"b is known", "cost_b > 0"}};
  return experiment;
}

}  // namespace

TEST_CASE("a plot has a point for each scene, and its slopes are values of trends") {
  const ComparisonResult result = two_scenes();
  ImagePairs pairs("nowhere");
  const Reproduction found = reproduce(with_plot("iterate_seconds"), result, pairs);
  REQUIRE(found.plots.size() == 1);
  REQUIRE(found.plots[0].lines.size() == 2);
  const Reproduction::Line& line = found.plots[0].lines[0];
  REQUIRE(line.points.size() == 2);
  CHECK(line.points[1].x == 400);
  CHECK(line.points[1].y == test::relative(8));
  CHECK(line.slope == test::relative(0.5));
  CHECK(found.plots[0].lines[1].points.empty());
  CHECK(found.trends[0].verdict == "holds");
  CHECK(found.trends[1].verdict == "unknown");
  CHECK(found.table().find("Cost: time [s] over triangles") != std::string::npos);
  CHECK(found.table().find("0.50") != std::string::npos);
}

TEST_CASE("of unlike machines, a plot of times has no slope and says so, and one of memory has") {
  ComparisonResult result = two_scenes();
  result.scenes[1].unlike_machines = true;
  ImagePairs pairs("nowhere");
  const Reproduction times = reproduce(with_plot("iterate_seconds"), result, pairs);
  CHECK(times.plots[0].lines[0].points.size() == 1);
  CHECK(std::isnan(times.plots[0].lines[0].slope));
  CHECK(times.trends[0].verdict == "unknown");
  CHECK(times.trends[0].unlike_machines);
  CHECK(reproduce(with_plot("peak_host_bytes"), result, pairs).plots[0].lines[0].points.size() == 2);
}

TEST_CASE("expressions know what a scene is rendered with") {
  const ComparisonResult result = two_scenes();
  Experiment experiment;
  for (const char* name : {"pixels", "max_bounces", "threads", "emissive_triangles", "processor_seconds"}) {
    ExperimentValue value;
    value.name = value.expression = name;
    value.variant = "a";
    value.scene = 1;
    experiment.values.push_back(value);
  }
  ImagePairs pairs("nowhere");
  std::vector<double> found;
  for (const Reproduction::Value& value : reproduce(experiment, result, pairs).values) found.push_back(value.ours);
  CHECK(found == std::vector<double>{200, 5, 3, 7, 16});
}

TEST_CASE("the metrics of a layer are those of that layer alone") {
  const test::TemporaryFolder folder;
  const auto write = [&](const char* name, float direct, float indirect) {
    Film film(16, 8);
    film.layer("direct", {"R", "G", "B"}, true).pixels.assign(3 * film.pixel_count(), direct);
    film.layer("indirect", {"R", "G", "B"}, true).pixels.assign(3 * film.pixel_count(), indirect);
    film.layer("depth", {"Y"}).pixels.assign(film.pixel_count(), 1.0f);
    write_exr(folder.path() / name, film);
  };
  write("reference.exr", 1, 2);
  write("piece.exr", 1.5, 1.75);
  ComparisonResult result = example({0, 8, 0, 0});
  result.pieces[0].image = "piece.exr";
  result.scenes[0].references.resize(1);
  result.scenes[0].references[0].image = "reference.exr";
  result.scenes[0].variants.resize(1);
  Experiment experiment;
  for (const char* layer : {"direct", "indirect", "depth", "none"}) {
    ExperimentValue value;
    value.name = layer;
    value.expression = "MSE";
    value.variant = "a";
    value.layer = layer;
    experiment.values.push_back(value);
  }
  // That of the image has no part in it.
  experiment.values.push_back(experiment.values[0]);
  experiment.values.back().name = experiment.values.back().expression = "debiased_relMSE";
  experiment.values.push_back(experiment.values[0]);
  experiment.values.back().name = experiment.values.back().expression = "relMSE_at_most";
  ImagePairs pairs(folder.path());
  const Reproduction found = reproduce(experiment, result, pairs);
  CHECK(found.values[0].ours == test::relative(0.25));
  CHECK(found.values[1].ours == test::relative(0.0625));
  CHECK(std::isnan(found.values[2].ours));
  CHECK(std::isnan(found.values[3].ours));
  CHECK(std::isnan(found.values[4].ours));
  CHECK(std::isnan(found.values[5].ours));
}

TEST_CASE("the reference's own error is taken off, unless it is most of what was measured") {
  ComparisonResult result = two_scenes();
  for (SceneResult& scene : result.scenes) {
    scene.references.resize(1);
    scene.variants.resize(1);
  }
  result.scenes[0].references[0].relmse = 0.04;
  result.scenes[1].references[0].relmse = 0.06;
  Experiment experiment;
  for (const size_t scene : {0, 1, 0, 1}) {
    ExperimentValue value;
    value.name = "x" + std::to_string(experiment.values.size());
    value.expression = experiment.values.size() < 2 ? "debiased_relMSE" : "relMSE_at_most";
    value.variant = "a";
    value.scene = scene;
    experiment.values.push_back(value);
  }
  ImagePairs pairs("nowhere");
  const Reproduction found = reproduce(experiment, result, pairs);  // relMSE is 0.1
  CHECK(found.values[0].ours == test::relative(0.06));
  CHECK(std::isnan(found.values[1].ours));
  CHECK(found.values[2].ours == test::relative(0.06));
  CHECK(found.values[3].ours == test::relative(0.06));  // the reference's own: no more than half is left of 0.1
}

TEST_CASE("what the quick setting leaves out is not measured, and what is of no paper has no column for one") {
  const ComparisonResult result = two_scenes();
  Experiment experiment;
  ExperimentValue value;
  value.name = value.expression = "relMSE";
  value.variant = "a";
  value.scene = no_position;
  experiment.values = {value};
  experiment.claim = "So it is.";
  experiment.own = true;
  ImagePairs pairs("nowhere");
  const Reproduction found = reproduce(experiment, result, pairs);
  CHECK(std::isnan(found.values[0].ours));
  CHECK(found.table().find("paper") == std::string::npos);
  CHECK(found.table().find("claim: So it is.") != std::string::npos);
}
