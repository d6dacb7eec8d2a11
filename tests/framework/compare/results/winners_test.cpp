// SPDX-License-Identifier: Apache-2.0
// Who is best on a scene within a budget, on results made by hand.
#include "lucarium/compare/results/winners.h"

#include <doctest/doctest.h>

#include <cmath>

#include "lucarium/base/json.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;

namespace {

/// One scene; the variants a, b, c have 3, 1 and 2 times a relMSE that varies from seed to seed by `spread`.
ComparisonResult example(const ComparisonBudget& budget, uint32_t seeds, double spread = 1) {
  ComparisonResult result;
  result.spec.scenes.resize(1);
  result.spec.variants = {{"a", {}, ""}, {"b", {}, ""}, {"c", {}, ""}};
  result.spec.budgets = {budget};
  result.variants.resize(3);
  result.scenes.resize(1);
  result.scenes[0].name = "box";
  const double errors[] = {0.3, 0.1, 0.2};
  for (size_t variant = 0; variant < 3; ++variant) {
    for (uint32_t seed = 1; seed <= seeds; ++seed) {
      PieceResult piece{0, variant, 0, seed};
      piece.metrics["relMSE"] = errors[variant] * (seed % 2 == variant % 2 ? spread : 1 / spread);
      piece.reached_seconds = 1 / errors[variant];
      piece.render_summary = R"({"passes": [], "counters": {}, "warnings": []})";
      result.pieces.push_back(piece);
    }
    Summary& summary = result.summaries[{0, variant, 0}];
    summary.seeds = seeds;
    summary.metrics["relMSE"].mean = errors[variant];
    if (budget.relmse > 0) summary.reached_seconds.emplace().mean = 1 / errors[variant];
  }
  return result;
}

}  // namespace

TEST_CASE("the lowest relMSE is best, and the next one has a factor of it") {
  const std::vector<Winner> winners = find_winners(example({4, 0, 0, 0}, 3));
  REQUIRE(winners.size() == 1);
  CHECK(winners[0].best == 1);
  CHECK(winners[0].next == 2);
  CHECK(winners[0].ratio.mean == test::relative(2));
  CHECK(winners[0].difference_shown());
  CHECK(describe_winners(example({4, 0, 0, 0}, 3)) == "best:\n  box, 4 s: b; c has 2 times its relMSE\n");
}

TEST_CASE("with a budget of relMSE, who gets there first is best") {
  const std::vector<Winner> winners = find_winners(example({0, 0, 0.1, 60}, 3));
  REQUIRE(winners.size() == 1);
  CHECK(winners[0].best == 0);
  CHECK(winners[0].next == 2);
  CHECK(winners[0].metric == "seconds");
  CHECK(winners[0].ratio.mean == test::relative(1.5));
}

TEST_CASE("what seeds do not show is not said") {
  CHECK(describe_winners(example({4, 0, 0, 0}, 1)).find("(one seed)") != std::string::npos);
  const ComparisonResult doubtful = example({4, 0, 0, 0}, 4, 3);
  CHECK_FALSE(find_winners(doubtful)[0].difference_shown());
  CHECK(describe_winners(doubtful).find("(no difference shown)") != std::string::npos);
}

TEST_CASE("of two close ones that is best that the pairs call so: the next one had 0.98 times its relMSE") {
  ComparisonResult result = example({4, 0, 0, 0}, 2);
  const auto set = [&](size_t variant, double first, double second) {
    result.pieces[2 * variant].metrics["relMSE"] = first;
    result.pieces[2 * variant + 1].metrics["relMSE"] = second;
    result.summaries.at({0, variant, 0}).metrics["relMSE"].mean = (first + second) / 2;
  };
  set(1, 0.01, 0.04);    // mean 0.025, geometric mean 0.02
  set(2, 0.02, 0.0245);  // mean 0.02225, geometric mean 0.0221
  const Winner winner = find_winners(result).at(0);
  CHECK(winner.best == 1);
  CHECK(winner.next == 2);
  CHECK(winner.ratio.mean == test::relative(std::sqrt(0.02 * 0.0245 / (0.01 * 0.04))));
  CHECK_FALSE(winner.difference_shown());
  CHECK(winner.ratio.low < 1);
}

TEST_CASE("what the reference cannot resolve is said") {
  ComparisonResult result = example({4, 0, 0, 0}, 3);
  result.summaries.at({0, 0, 0}).resolved = false;  // neither the best nor the next
  CHECK(find_winners(result)[0].resolved);
  result.summaries.at({0, 2, 0}).resolved = false;
  CHECK_FALSE(find_winners(result)[0].resolved);
  CHECK(describe_winners(result).find("(close to the reference's own error)") != std::string::npos);
}

TEST_CASE("nobody wins alone, nor by time where the machines were unlike") {
  ComparisonResult result = example({4, 0, 0, 0}, 3);
  result.scenes[0].unlike_machines = true;
  CHECK(find_winners(result).empty());
  CHECK(describe_winners(result).empty());
  ComparisonResult equal_work = example({0, 8, 0, 0}, 3);
  equal_work.scenes[0].unlike_machines = true;
  CHECK(find_winners(equal_work).size() == 1);
  equal_work.summaries.erase({0, 1, 0});
  equal_work.summaries.erase({0, 2, 0});
  CHECK(find_winners(equal_work).empty());
}

TEST_CASE("winners stand in the results") {
  const nlohmann::json winners = nlohmann::json::parse(example({4, 0, 0, 0}, 3).to_json()).at("winners");
  REQUIRE(winners.size() == 1);
  CHECK(winners[0].at("best") == 1);
  CHECK(winners[0].at("metric") == "relMSE");
  CHECK(winners[0].at("different") == true);
  CHECK(winners[0].at("ratio").at("mean").get<double>() == test::relative(2));
}
