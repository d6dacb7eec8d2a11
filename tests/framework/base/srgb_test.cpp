// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/srgb.h"

#include <doctest/doctest.h>

#include "tolerance.h"

using namespace lucarium;

TEST_CASE("sRGB: known values and the inverse") {
  CHECK(srgb_from_linear(0.21404114) == test::relative(0.5));
  CHECK(srgb_from_linear(0.18) == test::relative(0.461356, 1e-5));
  CHECK(srgb_from_linear(0.001) == test::relative(0.01292));
  CHECK(srgb_from_linear(0) == 0);
  CHECK(srgb_from_linear(1) == test::relative(1));
  for (double x = 0; x <= 1; x += 1. / 512) CHECK(linear_from_srgb(srgb_from_linear(x)) == test::relative(x, 1e-6));
}
