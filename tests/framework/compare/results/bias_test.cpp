// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/results/bias.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>

#include "lucarium/base/error.h"
#include "lucarium/metrics/metrics.h"
#include "tolerance.h"

using namespace lucarium;

namespace {

struct Truth {
  double bias = 0, deviation = 0, reference_deviation = 0;
};

/// Images of `pixels` grey-independent RGB pixels around 1 + bias, and a reference around 1.
struct Simulation {
  std::mt19937_64 random{7};
  std::normal_distribution<double> normal;

  std::vector<float> image(size_t pixels, double mean, double deviation) {
    std::vector<float> values(3 * pixels);
    for (float& v : values) v = static_cast<float>(mean + deviation * normal(random));
    return values;
  }
  SeedImages seeds(size_t count, size_t pixels, const Truth& truth) {
    std::vector<std::vector<float>> images;
    for (size_t s = 0; s < count; ++s) images.push_back(image(pixels, 1 + truth.bias, truth.deviation));
    return reduce_seed_images(images, image(pixels, 1, truth.reference_deviation), ErrorScale::absolute);
  }
};

struct Average {
  double sum = 0, squares = 0, count = 0;
  void add(double v) {
    sum += v;
    squares += v * v;
    ++count;
  }
  double mean() const { return sum / count; }
  double deviation() const { return std::sqrt(squares / count - mean() * mean()); }
  bool is(double expected) const { return std::abs(mean() - expected) < 4 * deviation() / std::sqrt(count); }
};

}  // namespace

TEST_CASE("two images of one pixel by hand") {
  // x = 1, 3 in every channel, r = 1: d = 0, 2; mean image off by 1; variance 2; bias² = 1 − 2/2 = ⟨d₁d₂⟩ = 0
  const BiasAndVariance split =
      split_error(reduce_seed_images({{1, 1, 1}, {3, 3, 3}}, {1, 1, 1}, ErrorScale::absolute), 0);
  CHECK(split.seeds == 2);
  CHECK(split.error == test::relative(2));
  CHECK(split.variance == test::relative(2));
  CHECK(split.error_of_mean == test::relative(1));
  CHECK(split.bias2 == test::within(0, 1e-6));
  CHECK(split.standard_errors == test::relative(1));
  CHECK(split.relative_mean.mean == test::relative(1));
  CHECK(split.mean_t == test::relative(1));
  CHECK(std::isnan(split.bias2_error));
}

TEST_CASE("the relative scale is that of relMSE, the absolute one that of MSE") {
  const std::vector<float> r = {1, 2, 4, .5f, .1f, 0}, x = {2, 2, 2, .4f, .3f, .1f}, y = {1.5f, 1, 4, .5f, .1f, .2f};
  const double relmse = (compute_metrics(2, 1, x, r).relmse + compute_metrics(2, 1, y, r).relmse) / 2,
               mse = (compute_metrics(2, 1, x, r).mse + compute_metrics(2, 1, y, r).mse) / 2;
  CHECK(split_error(reduce_seed_images({x, y}, r, ErrorScale::relative), 0).error == test::relative(relmse));
  CHECK(split_error(reduce_seed_images({x, y}, r, ErrorScale::absolute), 0).error == test::relative(mse));
}

TEST_CASE("bias², variance and error are estimated without bias, whatever noise the reference has") {
  Simulation simulation;
  for (const Truth& truth : {Truth{0, .3, 0}, Truth{.1, .3, 0}, Truth{.1, .3, .2}, Truth{0, .3, .2}}) {
    CAPTURE(truth.bias);
    CAPTURE(truth.reference_deviation);
    const double own = truth.reference_deviation * truth.reference_deviation;
    Average bias2, variance, error;
    for (int trial = 0; trial < 1000; ++trial) {
      const BiasAndVariance split = split_error(simulation.seeds(3, 60, truth), own);
      bias2.add(split.bias2);
      variance.add(split.variance);
      error.add(split.error);
    }
    CHECK(bias2.is(truth.bias * truth.bias));
    CHECK(variance.is(truth.deviation * truth.deviation));
    CHECK(error.is(truth.bias * truth.bias + truth.deviation * truth.deviation));
  }
}

TEST_CASE("the jackknife's standard error of bias² is right where there is bias, and known to be cautious where not") {
  // Without bias the products of pairs are uncorrelated, of variance v: that of their mean is 2v/(S(S−1)), and the
  // jackknife expects 4v/(S(S−2)).
  Simulation simulation;
  constexpr size_t seeds = 6;
  for (const double bias : {0.0, 0.2}) {
    Average bias2, error;
    for (int trial = 0; trial < 2000; ++trial) {
      const BiasAndVariance split = split_error(simulation.seeds(seeds, 30, {bias, bias > 0 ? .1 : .2, 0}), 0);
      bias2.add(split.bias2);
      error.add(split.bias2_error);
    }
    CAPTURE(bias);
    const double expected = bias > 0 ? 1 : std::sqrt(2 * (seeds - 1.0) / (seeds - 2.0));
    CHECK(std::sqrt(error.squares / error.count) / bias2.deviation() == test::relative(expected, .05));
  }
}

TEST_CASE("without bias the error of the mean is one standard error, with bias it is many") {
  Simulation simulation;
  const Truth unbiased{0, .3, .1}, biased{.1, .3, .1};
  CHECK(split_error(simulation.seeds(5, 20000, unbiased), .01).standard_errors == test::relative(1, .02));
  // √(1 + .1²/(.3²/5 + .1²)) = 1.165 for each pixel; the mean over the image leaves no doubt
  const BiasAndVariance split = split_error(simulation.seeds(5, 20000, biased), .01);
  CHECK(split.standard_errors == test::relative(std::sqrt(1 + .01 / .028), .02));
  CHECK(std::abs(split.mean_t) > 10);
  CHECK(split.relative_mean.low > .05);
  CHECK(split.relative_mean.low < .1);
  CHECK(split.relative_mean.high > .1);
}

TEST_CASE("images that do not vary: right ones are 0, wrong ones infinitely many standard errors off") {
  const std::vector<float> r = {1, 2, 3}, wrong = {1, 2, 4};
  CHECK(split_error(reduce_seed_images({r, r, r}, r, ErrorScale::relative), 0).standard_errors == 0);
  const BiasAndVariance split = split_error(reduce_seed_images({wrong, wrong, wrong}, r, ErrorScale::absolute), 0);
  CHECK(split.variance == test::within(0, 1e-6));
  CHECK(split.bias2 == test::relative(1. / 3));
  CHECK(split.bias2_error == test::within(0, 1e-6));
  CHECK(split.standard_errors > 1e6);
}

TEST_CASE("one seed splits nothing; NaN pixels are left out of all seeds; sizes must agree") {
  const BiasAndVariance one = split_error(reduce_seed_images({{1, 1, 2}}, {1, 1, 1}, ErrorScale::absolute), 0);
  CHECK(one.error == test::relative(1. / 3));
  CHECK(std::isnan(one.bias2));
  CHECK(std::isnan(one.variance));

  const float nan = std::numeric_limits<float>::quiet_NaN();
  const SeedImages images =
      reduce_seed_images({{1, 1, 1, 2, 2, 2}, {nan, 1, 1, 2, 2, 2}}, {5, 5, 5, 2, 2, 2}, ErrorScale::absolute);
  CHECK(images.nonfinite == 1);
  CHECK(split_error(images, 0).error == 0);
  CHECK_THROWS_AS(reduce_seed_images({{nan, 1, 1}}, {1, 1, 1}, ErrorScale::absolute), Error);
  CHECK_THROWS_AS(reduce_seed_images({{1, 1, 1, 1, 1, 1}}, {1, 1, 1}, ErrorScale::absolute), Error);
}
