// SPDX-License-Identifier: Apache-2.0
#include "lucarium/metrics/error_map.h"

#include <doctest/doctest.h>

#include <cstddef>
#include <limits>

#include "tolerance.h"

using namespace lucarium;

TEST_CASE("signed relative error by hand; pixels that are not finite are 1") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> reference = {2, 2, 2, 0, 0, 0}, test = {1, 1, 1, nan, 0, 0};
  const std::vector<float> error = signed_relative_error(test, reference);  // mean luminance 1
  CHECK(error[0] == test::relative(-1 / 2.01));
  CHECK(error[1] == 1);
}

TEST_CASE("colours of FLIP run from black to pale yellow, ever lighter") {
  const std::vector<float> map = color_error({-1, 0, .1f, .2f, .3f, .4f, .5f, .6f, .7f, .8f, .9f, 1, 2});
  CHECK(map[0] == map[3]);
  for (size_t p = 2; p < 12; ++p) {
    const auto luminance = [&](size_t i) {
      return .2126f * map[3 * i] + .7152f * map[3 * i + 1] + .0722f * map[3 * i + 2];
    };
    CHECK(luminance(p) > luminance(p - 1));
  }
  CHECK(map[3 * 11 + 1] == map[3 * 12 + 1]);
  CHECK(map[3 * 12 + 1] > .9f);
}
