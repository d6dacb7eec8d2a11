// SPDX-License-Identifier: Apache-2.0
#include "lucarium/film/exposure.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "tolerance.h"

using namespace lucarium;

namespace {

/// Pixels of one grey value each.
std::vector<float> greys(const std::vector<float>& values) {
  std::vector<float> rgb;
  for (const float value : values) rgb.insert(rgb.end(), {value, value, value});
  return rgb;
}

}  // namespace

TEST_CASE("a picture that a display shows well stays as it is") {
  CHECK(automatic_exposure(greys(std::vector<float>(100, 0.2f))) == 0);
  CHECK(automatic_exposure(greys(std::vector<float>(100, 1))) == 0);
  std::vector<float> lamp(100, 0.3f);  // a lamp of 17 on 5 % of the picture
  std::fill_n(lamp.begin(), 5, 17.f);
  CHECK(automatic_exposure(greys(lamp)) == 0);
}

TEST_CASE("a picture in lux or in the dark is brought to the nearer end of what a display shows") {
  CHECK(automatic_exposure(greys(std::vector<float>(100, 1024))) == -10);
  CHECK(automatic_exposure(greys(std::vector<float>(100, std::ldexp(0.2f, -8)))) == 8);
  // The 90th percentile of 1 … 1000 is 900: log2 900 = 9.81.
  std::vector<float> ramp;
  for (int i = 1; i <= 1000; ++i) ramp.push_back(static_cast<float>(i));
  CHECK(automatic_exposure(greys(ramp)) == test::relative(-9.8, 1e-6));
}

TEST_CASE("the brightest channel counts, since that is what clips") {
  CHECK(automatic_exposure({0, 0, 8, 0, 0, 8}) == -3);
  CHECK(automatic_exposure({0, 0, 0.5f}) == 0);
}

TEST_CASE("a black background, fireflies, NaN and infinity do not matter") {
  std::vector<float> values(1000, 0);
  std::fill_n(values.begin(), 100, 4.f);
  CHECK(automatic_exposure(greys(values)) == -2);
  std::fill_n(values.begin(), 9, 1e30f);
  CHECK(automatic_exposure(greys(values)) == -2);
  values[500] = std::numeric_limits<float>::quiet_NaN();
  values[501] = INFINITY;
  CHECK(automatic_exposure(greys(values)) == -2);
}

TEST_CASE("nothing lit and values at the end of the range give a number") {
  CHECK(automatic_exposure({}) == 0);
  CHECK(automatic_exposure(greys({0, 0, 0})) == 0);
  CHECK(automatic_exposure(greys({std::numeric_limits<float>::max()})) == -100);
  CHECK(automatic_exposure(greys({std::numeric_limits<float>::denorm_min()})) == 100);
  CHECK_FALSE(std::signbit(automatic_exposure(greys({1.01f}))));
}
