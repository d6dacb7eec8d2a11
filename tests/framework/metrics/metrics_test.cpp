// SPDX-License-Identifier: Apache-2.0
#include "lucarium/metrics/metrics.h"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "lucarium/base/error.h"
#include "tolerance.h"

using namespace lucarium;

TEST_CASE("metrics of one pixel by hand") {
  // Y = .2126·1 + .7152·2 + .0722·4 = 1.9318
  const ImageMetrics m = compute_metrics(1, 1, {2, 2, 2}, {1, 2, 4});
  const double y = 1.9318;
  CHECK(m.mse == test::relative(5.0 / 3));
  CHECK(m.rmse == test::relative(std::sqrt(5.0 / 3)));
  CHECK(m.relmse == test::relative((1 / (1 + .01 * y * y) + 4 / (16 + .01 * y * y)) / 3));
  CHECK(m.mape == test::relative((1 / (1 + .01 * y) + 2 / (4 + .01 * y)) / 3));
  CHECK(m.smape == test::relative((2 / (3 + .01 * y) + 4 / (6 + .01 * y)) / 3));
}

TEST_CASE("relMSE does not depend on the unit of radiance") {
  const std::vector<float> r = {.1f, .5f, 2, 0, 3, 1}, x = {.2f, .4f, 2, .1f, 2, 1};
  std::vector<float> r1000 = r, x1000 = x;
  for (float& v : r1000) v *= 1000;
  for (float& v : x1000) v *= 1000;
  CHECK(compute_metrics(2, 1, x, r).relmse == test::relative(compute_metrics(2, 1, x1000, r1000).relmse));
}

TEST_CASE("equal images: no error, infinite PSNR, SSIM 1") {
  const std::vector<float> image(16 * 16 * 3, 0.25f);
  const ImageMetrics m = compute_metrics(16, 16, image, image);
  CHECK(m.mse == 0);
  CHECK(std::isinf(m.psnr));
  CHECK(m.ssim == test::relative(1));
}

TEST_CASE("SSIM of the constants .5 and .6 (in sRGB) is .983609") {
  const auto linear = [](double s) { return static_cast<float>(std::pow((s + .055) / 1.055, 2.4)); };
  const std::vector<float> a(16 * 16 * 3, linear(.5)), b(16 * 16 * 3, linear(.6));
  CHECK(compute_metrics(16, 16, a, b).ssim == test::relative(.983609, 1e-5));
}

TEST_CASE("the trimmed relMSE forgets one firefly in a thousand pixels") {
  std::vector<float> r(1000 * 3, 1.f), x = r;
  for (int c = 0; c < 3; ++c) x[static_cast<size_t>(c)] = 1001.f;
  const ImageMetrics m = compute_metrics(1000, 1, x, r);
  CHECK(m.relmse > 900);
  CHECK(m.relmse_trimmed == 0);
}

TEST_CASE("MSE, RMSE and PSNR are those of OpenImageIO's comparison") {
  const uint32_t width = 37, height = 29;
  std::vector<float> reference(width * height * 3), test(reference.size());
  uint32_t state = 1;
  const auto random = [&] { return static_cast<float>((state = state * 1664525u + 1013904223u) >> 8) / 16777216.f; };
  for (size_t i = 0; i < reference.size(); ++i) {
    reference[i] = 3 * random();
    test[i] = reference[i] * (0.5f + random());
  }
  const auto compared = [&](std::vector<float> x, std::vector<float> r) {
    const OIIO::ImageSpec spec(static_cast<int>(width), static_cast<int>(height), 3, OIIO::TypeDesc::FLOAT);
    return OIIO::ImageBufAlgo::compare(OIIO::ImageBuf(spec, x.data()), OIIO::ImageBuf(spec, r.data()), 0, 0);
  };
  const ImageMetrics m = compute_metrics(width, height, test, reference);
  const auto linear = compared(test, reference);
  CHECK(m.rmse == test::relative(linear.rms_error, 1e-6));
  CHECK(m.mse == test::relative(linear.rms_error * linear.rms_error, 1e-6));
  // Its PSNR is over the greatest value, which is 1 in these images once they are clamped.
  const auto srgb = [](std::vector<float> image) {
    for (float& v : image) {
      v = std::min(v, 1.f);
      v = v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1 / 2.4f) - 0.055f;
    }
    return image;
  };
  CHECK(m.psnr == test::relative(compared(srgb(test), srgb(reference)).PSNR, 1e-6));
}

TEST_CASE("exposure: one stop more is an image of twice the radiance") {
  const std::vector<float> r = {.1f, .2f, .3f, .02f, .04f, .06f}, x = {.12f, .2f, .25f, .03f, .04f, .01f};
  std::vector<float> r2 = r, x2 = x;
  for (float& v : r2) v *= 2;
  for (float& v : x2) v *= 2;
  const ImageMetrics brighter = compute_metrics(2, 1, x, r, 1), doubled = compute_metrics(2, 1, x2, r2);
  CHECK(brighter.psnr == test::relative(doubled.psnr));
  CHECK(brighter.ldr_flip == test::relative(doubled.ldr_flip));
  CHECK(brighter.hdr_flip == test::relative(doubled.hdr_flip, 1e-5));
}

TEST_CASE("every metric is found by its name in any case; an unknown one is answered with the names") {
  for (const Metric& metric : metric_table()) {
    CHECK(find_metric(metric.name).value == metric.value);
    CHECK(!metric.formula.empty());
  }
  CHECK(find_metric("relmse").value == &ImageMetrics::relmse);
  CHECK_THROWS_WITH_AS(find_metric("rel"), doctest::Contains("relMSE_trimmed"), Error);
}

TEST_CASE("without FLIP, its values are not numbers and the others the same") {
  const std::vector<float> r(16 * 16 * 3, .5f), x(16 * 16 * 3, .6f);
  const ImageMetrics all = compute_metrics(16, 16, x, r), some = MetricReference(16, 16, r, {0, false}).measure(x);
  CHECK(std::isnan(some.ldr_flip));
  CHECK(std::isnan(some.hdr_flip));
  CHECK(some.ssim == all.ssim);
  CHECK(all.ldr_flip > 0);
}

TEST_CASE("relMSE can be had alone, and is refused as all are") {
  const std::vector<float> r(16 * 16 * 3, .5f), x(16 * 16 * 3, .6f);
  const MetricReference reference(16, 16, r);
  CHECK(reference.relmse(x) == reference.measure(x).relmse);
  CHECK_THROWS_AS(reference.relmse({1, 2, 3}), Error);
}

TEST_CASE("an image too small for SSIM's window has none") {
  CHECK(std::isnan(compute_metrics(10, 11, std::vector<float>(330, .5f), std::vector<float>(330, .6f)).ssim));
}

TEST_CASE("pixels that are not finite change no metric of the others") {
  // Only the middle pixel is wrong, and it is NaN: the rest is equal.
  std::vector<float> r(15 * 15 * 3, .5f), x = r;
  x[3 * 112] = std::numeric_limits<float>::quiet_NaN();
  const ImageMetrics m = compute_metrics(15, 15, x, r);
  CHECK(m.nonfinite == 1);
  CHECK(std::isinf(m.psnr));
  CHECK(m.ssim == test::relative(1));
  CHECK(m.ldr_flip == 0);
  CHECK(m.hdr_flip == 0);
  CHECK_THROWS_AS(compute_metrics(1, 1, {x[3 * 112], 0, 0}, {1, 1, 1}), Error);
}

TEST_CASE("a black reference gives finite errors") {
  const std::vector<float> black(16 * 16 * 3, 0.f), grey(16 * 16 * 3, .5f);
  const ImageMetrics m = compute_metrics(16, 16, grey, black);
  for (const Metric& metric : metric_table()) CHECK_MESSAGE(std::isfinite(m.*metric.value), metric.name);
}

TEST_CASE("NaN pixels are counted and left out; sizes must agree; the reference must be finite") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const ImageMetrics m = compute_metrics(2, 1, {nan, 1, 1, 1, 1, 1}, {1, 1, 1, 1, 1, 1});
  CHECK(m.nonfinite == 1);
  CHECK(m.mse == 0);
  CHECK_THROWS_AS(compute_metrics(1, 1, {1, 1, 1}, {1, 1, 1, 1, 1, 1}), Error);
  CHECK_THROWS_AS(compute_metrics(1, 1, {1, 1, 1}, {nan, 1, 1}), Error);
}
