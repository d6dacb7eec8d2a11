// SPDX-License-Identifier: Apache-2.0
// What seeds say together: summaries, pairs, gates, the change against a baseline; on results made by hand.
#include "lucarium/compare/results/summary.h"

#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <regex>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/json.h"
#include "lucarium/compare/results/baseline.h"
#include "lucarium/compare/results/piece.h"
#include "lucarium/film/image_io.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;

namespace {

/// A run whose relMSE is scale / t at t = 1, 2, 4 s; two processors were at work, and of later seeds less.
PieceResult make_piece(size_t variant, uint32_t seed, double scale) {
  PieceResult piece;
  piece.variant = variant;
  piece.seed = seed;
  piece.image = "x.exr";
  piece.render_summary = R"({"passes": [], "counters": {}, "warnings": []})";
  piece.prepare_seconds = 0.5;
  piece.iterate_seconds = 3.5;
  piece.processor_seconds = 8.0 / seed;
  for (const double t : {1.0, 2.0, 4.0}) {
    piece.snapshots.push_back({t,
                               static_cast<uint64_t>(t),
                               static_cast<uint64_t>(t),
                               {{"relMSE", scale / t}, {"MSE", scale / t}},
                               2 * t / seed});
  }
  piece.metrics = {{"relMSE", scale / 4}, {"MSE", scale / 4}, {"PSNR", 30 + static_cast<double>(seed)}};
  return piece;
}

/// One scene, two variants of which the second has four times the error, three seeds.
ComparisonResult example() {
  ComparisonResult result;
  result.spec.scenes.resize(1);
  result.spec.scenes[0].source = "builtin:cornell";
  result.spec.variants = {{"a", {}, ""}, {"b", {}, ""}};
  result.spec.budgets = {{4, 0, 0, 0}};
  result.variants.resize(2);
  result.scenes.resize(1);
  result.scenes[0].name = "builtin:cornell";
  result.scenes[0].references.resize(1);
  result.scenes[0].references[0].relmse = 0.001;
  result.scenes[0].references[0].mse = 0.002;
  result.scenes[0].variants.resize(2);
  for (uint32_t seed = 1; seed <= 3; ++seed) {
    const double factor = std::exp2(static_cast<double>(seed) - 2);
    result.pieces.push_back(make_piece(0, seed, 0.36 * factor));
    result.pieces.push_back(make_piece(1, seed, 1.44 * factor));
  }
  for (size_t variant = 0; variant < 2; ++variant) {
    result.summaries[{0, variant, 0}] =
        summarize(pieces_of(result, {0, variant, 0}), result.scenes[0].references[0], result.spec.budgets[0]);
  }
  add_times_to_error(result, 0, 0, result.summaries);
  return result;
}

}  // namespace

TEST_CASE("a summary has geometric means, debiased error, the curve and its slope") {
  ComparisonResult result = example();
  const Summary& summary = result.summaries.at({0, 0, 0});
  CHECK(summary.seeds == 3);
  CHECK(summary.metrics.at("relMSE").mean == test::relative(0.09));
  // Logarithms are −1, 0, 1 times ln 2 about the mean: s = ln 2, t(2 degrees of freedom, 95 %) = 4.3027.
  const double high = 0.09 * std::exp(4.3027 * std::log(2.0) / std::sqrt(3.0));
  CHECK(summary.metrics.at("relMSE").high == test::relative(high, 1e-4));
  CHECK(summary.metrics.at("PSNR").mean == test::relative(32));
  CHECK(summary.debiased_mse == test::relative((0.045 + 0.09 + 0.18) / 3 - 0.002));
  CHECK(summary.resolved);
  REQUIRE(summary.curve.size() == 3);
  CHECK(summary.curve[1].relmse.mean == test::relative(0.18));
  CHECK(summary.slope.mean == test::relative(-1));
  CHECK(summary.iterate_seconds == test::relative(3.5));

  ReferenceResult poor = result.scenes[0].references[0];
  poor.relmse = 0.02;
  CHECK_FALSE(summarize(pieces_of(result, {0, 0, 0}), poor, result.spec.budgets[0]).resolved);
}

TEST_CASE("times to errors are on the curves, and what was not reached says so") {
  ComparisonResult result = example();
  const std::vector<SummaryTime>& first = result.summaries.at({0, 0, 0}).times;
  REQUIRE_FALSE(first.empty());
  CHECK(first.front().relmse == test::relative(0.1));
  CHECK_FALSE(first.front().seconds);  // seed 3 ends at 0.18
  for (const SummaryTime& time : first) {
    if (time.relmse != test::relative(0.3)) continue;
    REQUIRE(time.seconds);
    CHECK(time.at_most);  // seed 1 begins at 0.18
  }
  const std::vector<SummaryTime>& second = result.summaries.at({0, 1, 0}).times;
  REQUIRE(second.size() == first.size());
  for (const SummaryTime& time : second) {
    if (time.relmse != test::relative(1.0)) continue;
    // 1.44 · {½, 1, 2} / t = 1: 1 (at most, the first snapshot), 1.44 and 2.88 s.
    REQUIRE(time.seconds);
    CHECK(time.seconds->mean == test::relative(std::cbrt(1.0 * 1.44 * 2.88)));
  }
}

TEST_CASE("processor seconds have curves and times of their own, but only where every piece says them") {
  ComparisonResult result = example();
  const Summary& first = result.summaries.at({0, 0, 0});
  CHECK(first.processor_seconds.value() == test::relative((8 + 4 + 8 / 3.0) / 3));
  REQUIRE(first.processor_curve.size() == 3);
  CHECK(first.processor_curve[0].seconds == test::relative(2));  // of the first seed
  // 0.18 / t of seed 1 at 2 t, 0.36 / t of seed 2 at t, 0.72 / t of seed 3 at 2 t / 3.
  CHECK(first.processor_curve[0].relmse.mean == test::relative(std::cbrt(0.18 * 0.18 * 0.24)));
  for (const SummaryTime& time : result.summaries.at({0, 1, 0}).processor_times) {
    if (time.relmse != test::relative(1.0)) continue;
    REQUIRE(time.seconds);  // at most 2 s; 1.44 s; two thirds of 2.88 s
    CHECK(time.seconds->mean == test::relative(std::cbrt(2.0 * 1.44 * 1.92)));
  }
  const nlohmann::json json = nlohmann::json::parse(result.to_json());
  CHECK(json["pieces"][0]["processor_seconds"] == 8);
  CHECK(json["pieces"][0]["snapshots"][2]["processor_seconds"] == 8);
  CHECK(json["summaries"][0]["processor_curve"][0]["processor_seconds"] == 2);
  CHECK(json["summaries"][0]["processor_time_to_error"].size() == first.times.size());
  CHECK(result.pieces_csv().find(",device_seconds,processor_seconds,") != std::string::npos);
  CHECK(result.snapshots_csv().find(",seconds,processor_seconds,") != std::string::npos);

  result.pieces[2].processor_seconds.reset();  // as in results of earlier versions, and on a GPU
  for (Snapshot& snapshot : result.pieces[2].snapshots) snapshot.processor_seconds.reset();
  const Summary without =
      summarize(pieces_of(result, {0, 0, 0}), result.scenes[0].references[0], result.spec.budgets[0]);
  CHECK(!without.processor_seconds);
  CHECK(without.processor_curve.empty());
  CHECK(without.curve.size() == 3);
}

TEST_CASE("a piece reads the processor seconds of its summary, and when its error was reached in them") {
  PieceResult piece;
  piece.render_summary = R"({"clocks": {"load_seconds": 0, "upload_seconds": 0, "bvh_seconds": 0, "prepare_seconds": 0,
    "compile_seconds": 0, "warm_up_seconds": 0, "iterate_seconds": 4, "processor_seconds": 8}, "parameters": "",
    "samples": 2, "iterations": 2, "converged": false, "peak_host_bytes": 1, "peak_device_memory_bytes": 1,
    "passes": [], "metrics": {}, "snapshots": [
      {"seconds": 1, "processor_seconds": 3, "iterations": 1, "samples": 1, "metrics": {"relMSE": 0.4}},
      {"seconds": 4, "processor_seconds": 12, "iterations": 2, "samples": 2, "metrics": {"relMSE": 0.1}}]})";
  ComparisonBudget budget;
  budget.relmse = 0.2;
  read_summary(piece, budget);
  CHECK(piece.processor_seconds == 8);
  CHECK(piece.reached_seconds.value() == test::relative(2));
  CHECK(piece.reached_processor_seconds.value() == test::relative(6));
}

TEST_CASE("a scene whose pieces ran on machines of several kinds has times to errors in processor seconds only") {
  ComparisonResult result = example();
  for (PieceResult& piece : result.pieces) {
    piece.machine.emplace();
    piece.machine->machine.cpu = "one kind";
    piece.machine->load = piece.seed;  // of like machines one may be busier
  }
  CHECK_FALSE(mark_unlike_machines(result, 0));
  add_times_to_error(result, 0, 0, result.summaries);
  CHECK_FALSE(result.summaries.at({0, 0, 0}).times.empty());
  const size_t errors = result.summaries.at({0, 0, 0}).times.size();
  CHECK(make_pairs(result).size() == 1);
  SUBCASE("another processor") { result.pieces.back().machine->machine.cpu = "another kind"; }
  SUBCASE("another device") { result.pieces.back().device = "another kind"; }
  CHECK(mark_unlike_machines(result, 0));
  CHECK(result.scenes[0].unlike_machines);
  add_times_to_error(result, 0, 0, result.summaries);
  CHECK(result.summaries.at({0, 0, 0}).times.empty());
  CHECK(result.summaries.at({0, 0, 0}).processor_times.size() == errors);
  CHECK(make_pairs(result).empty());  // errors at equal time say which machine is faster
  result.spec.budgets[0] = {0, 4, 0, 0};
  CHECK(make_pairs(result).size() == 1);
  result.spec.budgets[0] = {0, 0, 0.1, 0};
  for (PieceResult& piece : result.pieces) piece.reached_seconds = piece.reached_processor_seconds = 1;
  REQUIRE(make_pairs(result).size() == 1);
  CHECK(make_pairs(result)[0].metric == "processor_seconds");
  result.spec.budgets[0] = {4, 0, 0, 0};
  result.pieces.pop_back();
  CHECK_FALSE(mark_unlike_machines(result, 0));
}

TEST_CASE("pairs go by seeds: what the seeds have in common cancels") {
  ComparisonResult result = example();
  const std::vector<SummaryPair> pairs = make_pairs(result);
  REQUIRE(pairs.size() == 1);
  CHECK(pairs[0].metric == "relMSE");
  CHECK(pairs[0].ratio.mean == test::relative(0.25));
  CHECK(pairs[0].ratio.high == test::relative(0.25));
  CHECK(pairs[0].different());
}

TEST_CASE("gates") {
  ComparisonResult result = example();
  const auto passed = [&](const std::string& text) {
    std::vector<bool> list;
    for (const GateResult& gate : apply_gates({parse_gate(text)}, result)) list.push_back(gate.passed);
    return list;
  };
  CHECK(passed("relmse<0.2") == std::vector<bool>{true, false});
  CHECK(passed("b:relMSE<0.41") == std::vector<bool>{true});
  CHECK(passed("psnr>31") == std::vector<bool>{true, true});
  CHECK(passed("seconds<3.9") == std::vector<bool>{false, false});
  CHECK(passed("HDR_FLIP<1") == std::vector<bool>{false, false});  // no result clears no bar
  CHECK_THROWS_AS(passed("c:relmse<1"), Error);
  for (const char* text : {"relmse", "relmse<", "<1", "relmse<1x", "relms<1", ""})
    CHECK_THROWS_AS(parse_gate(text), Error);
}

TEST_CASE("of unlike machines, gates on seconds are unknown, whatever their bar") {
  ComparisonResult result = example();
  result.scenes[0].unlike_machines = true;
  for (const char* text : {"seconds<1000", "seconds>0", "prepare_seconds<1000"}) {
    CAPTURE(text);
    for (const GateResult& gate : apply_gates({parse_gate(text)}, result)) {
      CHECK(std::isnan(gate.value));
      CHECK(gate.unlike_machines);
      CHECK_FALSE(gate.passed);
    }
  }
  result.spec.budgets[0] = {0, 4, 0, 0};  // iterations
  const std::vector<GateResult> others = apply_gates({parse_gate("psnr>31"), parse_gate("peak_host_bytes<1")}, result);
  REQUIRE(others.size() == 4);
  for (const GateResult& gate : others) {
    CHECK(gate.passed);
    CHECK_FALSE(gate.unlike_machines);
  }
  // What was reached in a time is no more comparable than the time.
  result.spec.budgets[0] = {4, 0, 0, 0};
  for (const GateResult& gate : apply_gates({parse_gate("psnr>31")}, result)) CHECK(gate.unlike_machines);
  for (const GateResult& gate : apply_gates({parse_gate("peak_host_bytes<1")}, result)) CHECK(gate.passed);
  result.gates = apply_gates({parse_gate("seconds<1000")}, result);
  CHECK(nlohmann::json::parse(result.to_json())["gates"][0]["unlike_machines"] == true);
}

TEST_CASE("results survive as JSON, and another run is compared with them") {
  const test::TemporaryFolder folder;
  ComparisonResult result = example();
  write_file_atomically(folder.path() / "results.json", result.to_json());
  const nlohmann::json json = nlohmann::json::parse(result.to_json());
  CHECK(json["summaries"].size() == 2);
  CHECK(json["summaries"][0]["metrics"]["relMSE"]["mean"].get<double>() == test::relative(0.09));
  CHECK(json["pieces"].size() == 6);

  for (PieceResult& piece : result.pieces) piece.metrics["relMSE"] *= piece.variant == 0 ? 1e-3 : 1;
  result.spec.variants[1].name = "new";
  const BaselineComparison comparison = compare_with_baseline(result, folder.path());
  REQUIRE(comparison.changes.size() == 2);  // relMSE and seconds of variant a
  CHECK(comparison.changes[0].metric == "relMSE");
  CHECK(comparison.changes[0].ratio.mean == test::relative(1e-3));
  CHECK(comparison.changes[0].verdict == "better");
  CHECK(comparison.changes[1].verdict == "same");
  REQUIRE(comparison.missing.size() == 1);
  CHECK(comparison.missing[0].find("new") != std::string::npos);
  CHECK_THROWS_AS(compare_with_baseline(result, folder.path() / "nowhere"), Error);
}

TEST_CASE("against a baseline of another machine, times are not judged") {
  const test::TemporaryFolder folder;
  ComparisonResult result = example();
  for (PieceResult& piece : result.pieces) piece.machine.emplace().machine.cpu = "one kind";
  write_file_atomically(folder.path() / "results.json", result.to_json());
  for (PieceResult& piece : result.pieces) piece.metrics["relMSE"] *= 1e-3;
  const auto verdict = [&](size_t change) {
    return compare_with_baseline(result, folder.path()).changes.at(change).verdict;
  };
  CHECK(verdict(0) == "better");
  CHECK(verdict(1) == "same");
  for (PieceResult& piece : result.pieces) piece.machine->machine.cpu = "another kind";
  CHECK(verdict(0) == "unknown");  // errors at equal time
  CHECK(verdict(1) == "unknown");
  result.spec.budgets[0] = {0, 4, 0, 0};
  write_file_atomically(folder.path() / "results.json",
                        std::regex_replace(result.to_json(), std::regex("another kind"), "one kind"));
  CHECK(verdict(0) == "same");  // of equal work it does not matter where
  CHECK(verdict(1) == "unknown");
}

TEST_CASE("against a baseline, times are not judged where pieces of either ran on several devices") {
  const test::TemporaryFolder folder;
  ComparisonResult result = example();
  const auto put_on = [&](PieceResult& piece, const std::string& device) {
    nlohmann::json summary = nlohmann::json::parse(piece.render_summary);
    summary["device"] = device;
    piece.render_summary = summary.dump();
  };
  const auto write = [&] { write_file_atomically(folder.path() / "results.json", result.to_json()); };
  const auto verdict = [&] { return compare_with_baseline(result, folder.path()).changes.at(1).verdict; };
  for (PieceResult& piece : result.pieces) put_on(piece, "one device");
  result.device = "one device";
  write();
  CHECK(verdict() == "same");
  put_on(result.pieces.front(), "another device");  // the device that the results name is still the last piece's
  CHECK(verdict() == "unknown");
  write();
  put_on(result.pieces.front(), "one device");
  CHECK(verdict() == "unknown");
  // Earlier versions named the device of all pieces once.
  nlohmann::json old = nlohmann::json::parse(result.to_json());
  for (nlohmann::json& piece : old["pieces"]) piece.erase("device");
  write_file_atomically(folder.path() / "results.json", old.dump());
  CHECK(verdict() == "same");
  old["device"] = "another device";
  write_file_atomically(folder.path() / "results.json", old.dump());
  CHECK(verdict() == "unknown");
}

TEST_CASE("Welch's ratio holds the truth as often as it says") {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  int held = 0;
  const int runs = 4000;
  for (int run = 0; run < runs; ++run) {
    std::vector<double> now, then;
    for (int i = 0; i < 4; ++i) now.push_back(2 * std::exp(0.3 * normal(random)));
    for (int i = 0; i < 6; ++i) then.push_back(std::exp(0.1 * normal(random)));
    const ConfidenceInterval ratio = welch_ratio(now, then);
    held += ratio.low <= 2 && 2 <= ratio.high;
  }
  // Welch's approximation is good to about 1 % here; the count's own deviation is 0.0034.
  CHECK(held / static_cast<double>(runs) == test::relative(0.95, 0.02));
}

TEST_CASE("the mean over seeds is written, and its bias separated from its variance") {
  const test::TemporaryFolder folder;
  std::mt19937 random(5);
  std::normal_distribution<float> noise(0, 0.1f);
  const auto write = [&](const char* name, float value, bool noisy) {
    Film film(64, 64);
    for (float& pixel : film.layer("direct", {"R", "G", "B"}, true).pixels) pixel = value + (noisy ? noise(random) : 0);
    write_exr(folder.path() / name, film);
  };
  std::filesystem::create_directories(folder.path() / "means");
  write("reference.exr", 1, false);
  ComparisonResult result = example();
  result.pieces.resize(0);
  for (uint32_t seed = 1; seed <= 3; ++seed) {
    result.pieces.push_back(make_piece(0, seed, 1));
    result.pieces.back().image = "seed" + std::to_string(seed) + ".exr";
    write(result.pieces.back().image.c_str(), 1.05f, true);
  }
  ReferenceResult reference;
  reference.image = "reference.exr";
  const BiasAndVariance bias = measure_bias(pieces_of(result, {0, 0, 0}), reference, folder.path());
  // 12288 values: variance 0.01 to √(2/24576), bias² 0.0025 to a few per cent.
  CHECK(bias.variance == test::relative(0.01, 0.05));
  CHECK(bias.bias2 == test::relative(0.0025, 0.1));
  CHECK(bias.standard_errors > 1.2);
  const Film mean = read_image(folder.path() / "means/scene1-variant1-budget1.exr");
  double sum = 0;
  for (const float value : mean.image()) sum += value;
  CHECK(sum / (64 * 64 * 3) == test::relative(1.05, 0.003));
}
