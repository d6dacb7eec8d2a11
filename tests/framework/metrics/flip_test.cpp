// SPDX-License-Identifier: Apache-2.0
// FLIP against numbers of the authors' implementation (its C++ header, version 1.7), to the digits given.
#include "lucarium/metrics/flip.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "lucarium/base/error.h"
#include "tolerance.h"

using namespace lucarium;

namespace {

constexpr uint32_t size = 64;
using Image = std::vector<float>;
using Color = std::array<float, 3>;

template <typename Function>
Image make_image(const Function& color_at) {
  Image image;
  for (uint32_t y = 0; y < size; ++y) {
    for (uint32_t x = 0; x < size; ++x) {
      const Color color = color_at(x, y);
      image.insert(image.end(), color.begin(), color.end());
    }
  }
  return image;
}

Image constant(Color color) {
  return make_image([&](uint32_t, uint32_t) { return color; });
}

double mean(const Image& map) { return std::accumulate(map.begin(), map.end(), 0.0) / static_cast<double>(map.size()); }

double ldr_flip(const Image& reference, const Image& test, double pixels_per_degree = flip_pixels_per_degree) {
  return mean(FlipReference(size, size, reference, {{0, false}}, pixels_per_degree).error_map(test));
}

Image hdr_map(const Image& reference, const Image& test) {
  return FlipReference(size, size, reference, hdr_flip_views(hdr_flip_exposures(reference))).error_map(test);
}

/// Two ramps and a checkerboard.
Image pattern() {
  return make_image([](uint32_t x, uint32_t y) {
    return Color{static_cast<float>(x) / 63, static_cast<float>(y) / 63, (x / 8 + y / 8) % 2 == 1 ? .8f : .2f};
  });
}

/// The pattern with grey noise in [−.1, .1], clamped to [0,1].
Image noisy_pattern() {
  Image image = pattern();
  for (uint32_t y = 0; y < size; ++y) {
    for (uint32_t x = 0; x < size; ++x) {
      uint32_t h = x * 73856093u ^ y * 19349663u;
      h ^= h >> 13;
      h *= 0x5bd1e995u;
      h ^= h >> 15;
      const float noise = static_cast<float>(h & 65535u) / 65535.f - .5f;
      for (size_t c = 0; c < 3; ++c) {
        float& value = image[3 * (y * size + x) + c];
        value = std::min(1.f, std::max(0.f, value + .2f * noise));
      }
    }
  }
  return image;
}

/// Times 2^((x−32)/8): eight stops from left to right.
Image high_range(Image image) {
  for (size_t p = 0; p < size * size; ++p) {
    for (size_t c = 0; c < 3; ++c) image[3 * p + c] *= std::exp2((static_cast<float>(p % size) - 32) / 8);
  }
  return image;
}

}  // namespace

TEST_CASE("FLIP of constant images") {
  CHECK(ldr_flip(constant({.5f, .5f, .5f}), constant({.5f, .5f, .5f})) == 0);
  CHECK(ldr_flip(constant({0, 0, 0}), constant({1, 1, 1})) == test::within(.96738, 1e-4));
  CHECK(ldr_flip(constant({.5f, .5f, .5f}), constant({.6f, .6f, .6f})) == test::within(.19621, 1e-4));
  CHECK(ldr_flip(constant({0, 1, 0}), constant({0, 0, 1})) == test::within(1, 1e-4));
  CHECK(ldr_flip(constant({1, 0, 0}), constant({0, 1, 0})) == test::within(.98666, 1e-4));
}

TEST_CASE("LDR-FLIP of a noisy pattern at two viewing distances") {
  CHECK(ldr_flip(pattern(), noisy_pattern()) == test::within(.080495, 1e-4));
  CHECK(ldr_flip(pattern(), noisy_pattern(), 32) == test::within(.148868, 1e-4));
}

TEST_CASE("HDR-FLIP of the pattern over eight stops, and its exposures") {
  const Image reference = high_range(pattern()), test = high_range(noisy_pattern());
  const HdrFlipExposures exposures = hdr_flip_exposures(reference);
  CHECK(exposures.start == test::within(-2.7059, 1e-4));
  CHECK(exposures.stop == test::within(2.2498, 1e-4));
  CHECK(exposures.count == 5);
  const std::vector<FlipView> views = hdr_flip_views(exposures);
  CHECK(views.front().exposure_stops == exposures.start);
  CHECK(views.back().exposure_stops == test::relative(exposures.stop));
  CHECK(mean(hdr_map(reference, test)) == test::within(.114027, 1e-4));
}

TEST_CASE("HDR-FLIP does not depend on the unit of radiance") {
  Image reference = high_range(pattern()), test = high_range(noisy_pattern());
  const double error = mean(hdr_map(reference, test));
  for (float& v : reference) v *= 1024;
  for (float& v : test) v *= 1024;
  CHECK(mean(hdr_map(reference, test)) == test::relative(error, 1e-6));
}

TEST_CASE("exposures of references that are mostly or entirely black") {
  // A median of 0 would ask for infinitely many stops. Of the pixels that are not black, the median is 1/4.
  Image reference = constant({0, 0, 0});
  for (size_t i = 0; i < 3; ++i) reference[i] = 1;
  for (size_t i = 3; i < 9; ++i) reference[i] = .25f;
  const HdrFlipExposures exposures = hdr_flip_exposures(reference);
  CHECK(exposures.stop - exposures.start == test::relative(2));
  CHECK(exposures.count == 2);
  for (const float error : hdr_map(reference, constant({.1f, .1f, .1f}))) REQUIRE(std::isfinite(error));

  const HdrFlipExposures black = hdr_flip_exposures(constant({0, 0, 0}));
  CHECK(black.start == 0);
  CHECK(black.stop == 0);
  CHECK(black.count == 2);

  Image sun = constant({1e-9f, 1e-9f, 1e-9f});
  for (size_t i = 0; i < 3; ++i) sun[i] = 1e9f;
  CHECK(hdr_flip_exposures(sun).count == 20);
}

TEST_CASE("a pixel that is not finite has error 1 and leaves its neighbours alone") {
  const Image reference = constant({.5f, .5f, .5f});
  Image test = reference;
  test[3 * (32 * size + 32) + 1] = std::numeric_limits<float>::quiet_NaN();
  const Image map = hdr_map(reference, test);
  for (size_t p = 0; p < map.size(); ++p) REQUIRE(map[p] == (p == 32 * size + 32 ? 1 : 0));
}

TEST_CASE("negative and huge radiance stays within [0,1]") {
  const Image reference = high_range(pattern());
  Image test = reference;
  for (size_t i = 0; i < test.size(); i += 7) test[i] = i % 2 ? -1e30f : 1e30f;
  for (const float error : hdr_map(reference, test)) REQUIRE((error >= 0 && error <= 1));
}

TEST_CASE("images of one pixel and of other sizes") {
  CHECK(FlipReference(1, 1, {0, 0, 0}, {{0, false}}).error_map({1, 1, 1})[0] == test::within(.96738, 1e-4));
  CHECK_THROWS_AS(FlipReference(1, 1, {0, 0, 0}, {{0, false}}).error_map({1, 1, 1, 1, 1, 1}), Error);
  CHECK_THROWS_AS(FlipReference(2, 1, {0, 0, 0}, {{0, false}}), Error);
}
