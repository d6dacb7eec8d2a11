// SPDX-License-Identifier: Apache-2.0
#include "lucarium/statistics/statistics.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>

#include "lucarium/base/error.h"
#include "tolerance.h"

using namespace lucarium;

namespace {

/// Share of `trials` in which the interval of `seeds` draws holds the truth.
template <typename Draw>
double coverage(size_t trials, size_t seeds, double truth, const Draw& interval_of_draws) {
  size_t held = 0;
  for (size_t i = 0; i < trials; ++i) {
    const ConfidenceInterval mean = interval_of_draws(seeds);
    held += mean.low <= truth && truth <= mean.high;
  }
  return static_cast<double>(held) / static_cast<double>(trials);
}

/// Within 3.5 standard errors of a 95 % coverage.
bool is_95_percent(double share, size_t trials) {
  return std::abs(share - 0.95) < 3.5 * std::sqrt(0.95 * 0.05 / static_cast<double>(trials));
}

}  // namespace

TEST_CASE("interval of three values by hand") {
  // mean 2, s = 1, t(2) = 4.302653: 2 ± 4.302653/√3
  const ConfidenceInterval mean = seed_mean({1, 2, 3});
  CHECK(mean.mean == 2);
  CHECK(mean.low == test::relative(2 - 4.302653 / std::sqrt(3)));
  CHECK(mean.high == test::relative(2 + 4.302653 / std::sqrt(3)));
  CHECK(mean.seeds == 3);
  const ConfidenceInterval narrow = seed_mean({1, 2, 3}, 0.5);
  CHECK(narrow.high - 2 == test::relative(0.816497 / std::sqrt(3)));  // t of two sides, 50 %, 2 degrees of freedom
}

TEST_CASE("geometric mean by hand; scaling the values scales the interval") {
  const ConfidenceInterval mean = seed_geometric_mean({1, 10, 100});
  CHECK(mean.mean == test::relative(10));
  CHECK(mean.high == test::relative(10 * std::pow(10, 4.302653 / std::sqrt(3))));
  CHECK(mean.low == test::relative(100 / mean.high));
  CHECK(seed_geometric_mean({7, 70, 700}).high == test::relative(7 * mean.high));
}

TEST_CASE("what one seed, no seed, NaN, zero and infinity give") {
  CHECK(seed_mean({5}).mean == 5);
  CHECK(std::isinf(seed_mean({5}).high));
  CHECK(seed_geometric_mean({5}).low == 0);
  CHECK(std::isinf(seed_geometric_mean({5}).high));
  CHECK(std::isnan(seed_mean({}).mean));
  CHECK(std::isnan(seed_mean({1, std::nan("")}).high));
  CHECK(std::isnan(seed_geometric_mean({0, std::nan("")}).mean));
  CHECK(seed_mean({2, 2, 2}).low == 2);
  CHECK(std::isinf(seed_mean({1, std::numeric_limits<double>::infinity()}).low));
  CHECK(seed_geometric_mean({0, 0}).high == 0);
  CHECK(seed_geometric_mean({0, 1}).mean == 0);
  CHECK(std::isinf(seed_geometric_mean({0, 1}).high));
  CHECK_THROWS_AS(seed_geometric_mean({-1, 1}), Error);
}

TEST_CASE("pairs cancel what the seeds share") {
  const std::vector<double> a = {1, 10, 100}, b = {2, 20, 200};
  CHECK(paired_ratio(a, b).mean == test::relative(.5));
  CHECK(paired_ratio(a, b).high == test::relative(.5));
  CHECK(paired_difference(b, {1, 19, 199}).mean == 1);
  CHECK(paired_ratio({0, 0}, {0, 0}).high == 1);
  CHECK_THROWS_AS(paired_ratio(a, {1, 2}), Error);
  CHECK_THROWS_AS(paired_difference(a, {1, 2}), Error);
}

TEST_CASE("95 % of the intervals hold the expected value") {
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  constexpr size_t trials = 5000;
  for (const size_t seeds : {2, 3, 10}) {
    CAPTURE(seeds);
    const auto draw = [&](size_t n, double center, double spread) {
      std::vector<double> values(n);
      for (double& v : values) v = center + spread * normal(random);
      return values;
    };
    CHECK(is_95_percent(coverage(trials, seeds, 3, [&](size_t n) { return seed_mean(draw(n, 3, 2)); }), trials));
    CHECK(is_95_percent(coverage(trials, seeds, std::exp(-4),
                                 [&](size_t n) {
                                   std::vector<double> errors = draw(n, -4, 1);
                                   for (double& e : errors) e = std::exp(e);
                                   return seed_geometric_mean(errors);
                                 }),
                        trials));
    // b is 1.3 a times a small noise, both share a large one
    CHECK(is_95_percent(coverage(trials, seeds, 1 / 1.3,
                                 [&](size_t n) {
                                   const std::vector<double> shared = draw(n, 0, 3), own = draw(n, 0, .05);
                                   std::vector<double> a(n), b(n);
                                   for (size_t i = 0; i < n; ++i) {
                                     a[i] = std::exp(shared[i]);
                                     b[i] = 1.3 * std::exp(shared[i] + own[i]);
                                   }
                                   return paired_ratio(a, b);
                                 }),
                        trials));
  }
}

TEST_CASE("an error that the reference cannot resolve is marked") {
  const DebiasedError clear = debiased_error(1, .1), hazy = debiased_error(1, .11);
  CHECK(clear.value == test::relative(.9));
  CHECK(clear.resolved);
  CHECK(hazy.value == test::relative(.89));
  CHECK(!hazy.resolved);
  CHECK(debiased_error(0, 0).resolved);
  CHECK(!debiased_error(0, 1e-9).resolved);
}
