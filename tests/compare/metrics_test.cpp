// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/metrics.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "lucarium/base/error.h"

using namespace lucarium;

TEST_CASE("metrics of one pixel by hand") {
  // Y = .2126·1 + .7152·2 + .0722·4 = 1.9318
  const ImageMetrics m = compute_metrics(1, 1, {2, 2, 2}, {1, 2, 4});
  const double y = 1.9318;
  CHECK(m.mse == doctest::Approx(5.0 / 3));
  CHECK(m.rmse == doctest::Approx(std::sqrt(5.0 / 3)));
  CHECK(m.relmse == doctest::Approx((1 / (1 + .01 * y * y) + 4 / (16 + .01 * y * y)) / 3));
  CHECK(m.mape == doctest::Approx((1 / (1 + .01 * y) + 2 / (4 + .01 * y)) / 3));
  CHECK(m.smape == doctest::Approx((2 / (3 + .01 * y) + 4 / (6 + .01 * y)) / 3));
}

TEST_CASE("relMSE does not depend on the unit of radiance") {
  const std::vector<float> r = {.1f, .5f, 2, 0, 3, 1}, x = {.2f, .4f, 2, .1f, 2, 1};
  std::vector<float> r1000 = r, x1000 = x;
  for (float& v : r1000) v *= 1000;
  for (float& v : x1000) v *= 1000;
  CHECK(compute_metrics(2, 1, x, r).relmse == doctest::Approx(compute_metrics(2, 1, x1000, r1000).relmse));
}

TEST_CASE("equal images: no error, infinite PSNR, SSIM 1") {
  const std::vector<float> image(16 * 16 * 3, 0.25f);
  const ImageMetrics m = compute_metrics(16, 16, image, image);
  CHECK(m.mse == 0);
  CHECK(std::isinf(m.psnr));
  CHECK(m.ssim == doctest::Approx(1));
}

TEST_CASE("SSIM of the constants .5 and .6 (in sRGB) is .983609") {
  const auto linear = [](double s) { return static_cast<float>(std::pow((s + .055) / 1.055, 2.4)); };
  const std::vector<float> a(16 * 16 * 3, linear(.5)), b(16 * 16 * 3, linear(.6));
  CHECK(compute_metrics(16, 16, a, b).ssim == doctest::Approx(.983609).epsilon(1e-5));
}

TEST_CASE("the trimmed relMSE forgets one firefly in a thousand pixels") {
  std::vector<float> r(1000 * 3, 1.f), x = r;
  for (int c = 0; c < 3; ++c) x[static_cast<size_t>(c)] = 1001.f;
  const ImageMetrics m = compute_metrics(1000, 1, x, r);
  CHECK(m.relmse > 900);
  CHECK(m.relmse_trimmed == 0);
}

TEST_CASE("NaN pixels are counted and left out; sizes must agree; the reference must be finite") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const ImageMetrics m = compute_metrics(2, 1, {nan, 1, 1, 1, 1, 1}, {1, 1, 1, 1, 1, 1});
  CHECK(m.nonfinite == 1);
  CHECK(m.mse == 0);
  CHECK_THROWS_AS(compute_metrics(1, 1, {1, 1, 1}, {1, 1, 1, 1, 1, 1}), Error);
  CHECK_THROWS_AS(compute_metrics(1, 1, {1, 1, 1}, {nan, 1, 1}), Error);
}
