// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/results/error_curve.h"

#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "tolerance.h"

using namespace lucarium;
using State = TimeToError::State;

namespace {

/// e = 3 t^−1.5 at 1, 2, 4, …, 64 s.
std::vector<CurvePoint> power_law() {
  std::vector<CurvePoint> curve;
  for (double t = 1; t <= 64; t *= 2) curve.push_back({t, 3 * std::pow(t, -1.5)});
  return curve;
}

/// MSE of the running mean of 64 normal pixels, at 1, 2, 4, …, `last` samples: snapshots share samples, as those of a
/// progressive renderer do.
std::vector<CurvePoint> progressive_run(std::mt19937_64& random, int last) {
  std::normal_distribution<double> normal;
  std::vector<double> sums(64, 0.);
  std::vector<CurvePoint> curve;
  for (int samples = 1; samples <= last; ++samples) {
    double mse = 0;
    for (double& sum : sums) {
      sum += normal(random);
      mse += sum * sum / (64. * samples * samples);
    }
    if ((samples & (samples - 1)) == 0) curve.push_back({static_cast<double>(samples), mse});
  }
  return curve;
}

}  // namespace

TEST_CASE("a power law is interpolated exactly") {
  for (const double t : {1.1, 3., 40.}) {
    const TimeToError time = time_to_error(power_law(), 3 * std::pow(t, -1.5));
    CHECK(time.state == State::reached);
    CHECK(time.time == test::relative(t));
    CHECK(error_at_time(power_law(), t) == test::relative(3 * std::pow(t, -1.5)));
  }
  CHECK(time_to_error(power_law(), power_law()[2].error).time == test::relative(4));
  CHECK(error_at_time(power_law(), 4) == power_law()[2].error);
}

TEST_CASE("outside the curve nothing is made up") {
  CHECK(time_to_error(power_law(), 1e-9).state == State::not_reached);
  CHECK(std::isinf(time_to_error(power_law(), 1e-9).time));
  CHECK(time_to_error(power_law(), 10).state == State::before_first);
  CHECK(time_to_error(power_law(), 10).time == 1);
  CHECK(time_to_error({}, 1).state == State::not_reached);
  CHECK(std::isnan(error_at_time(power_law(), .5)));
  CHECK(std::isnan(error_at_time(power_law(), 65)));
}

TEST_CASE("the first crossing counts; zeros and NaN do not spoil it") {
  const std::vector<CurvePoint> bumpy = {{1, 8}, {2, 2}, {4, 8}, {8, 1}};
  CHECK(time_to_error(bumpy, 4).time == test::relative(std::sqrt(2)));
  CHECK(time_to_error({{1, 8}, {2, 0}}, 4).time == 2);
  CHECK(time_to_error({{1, std::nan("")}, {2, 1}}, 4).time == 2);
  CHECK(error_at_time({{1, 8}, {2, 0}}, 1.5) == 0);
}

TEST_CASE("slope and scale of a power law") {
  const PowerLaw law = fit_power_law(power_law());
  CHECK(law.slope == test::relative(-1.5));
  CHECK(law.scale == test::relative(3));
  CHECK(law.points == 7);
  CHECK(fit_power_law({{1, 1}, {2, 0}, {4, .25}}).slope == test::relative(-1));
  CHECK(std::isnan(fit_power_law({{1, 1}}).slope));
  CHECK(std::isnan(fit_power_law({{1, 1}, {1, 2}}).slope));
  CHECK(std::isnan(fit_power_law({}).scale));
}

TEST_CASE("95 % of the seeds' intervals hold the slope −1 of progressive Monte Carlo") {
  std::mt19937_64 random(11);
  constexpr int trials = 1000;
  int held = 0;
  for (int trial = 0; trial < trials; ++trial) {
    std::vector<std::vector<CurvePoint>> curves;
    for (int seed = 0; seed < 3; ++seed) curves.push_back(progressive_run(random, 32));
    const ConfidenceInterval slope = seed_slope(curves);
    held += slope.low <= -1 && -1 <= slope.high;
  }
  const double share = static_cast<double>(held) / trials;
  CAPTURE(share);
  CHECK(std::abs(share - .95) < 3.5 * std::sqrt(.95 * .05 / trials));
}
