// SPDX-License-Identifier: Apache-2.0
// node_shading=dynamic: the light sample that a leaf keeps of all it gets.
#include <doctest/doctest.h>

#include <cmath>
#include <numeric>

#include "micro_fixture.h"
#include "micro_rendering/shared/micro_types.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

TEST_CASE("a leaf keeps a light sample in proportion to its luminance, and the sum of all") {
  const std::vector<float> luminances = {1, 4, 0, 2, 1};
  const float sum = std::accumulate(luminances.begin(), luminances.end(), 0.f);
  constexpr uint32_t leaves = 1 << 15;
  const auto in = test_buffer(luminances);
  const auto lights = test_buffer<MicroLeafLight>(leaves);
  run_kernel(micro_program("test_micro_rendering/light/kept_sample.cl"), "keep_samples", leaves, 64,
             [&](PassBuilder& pass) {
               pass.arg("luminances", in)
                   .arg("samples", static_cast<uint32_t>(luminances.size()))
                   .arg("count", leaves)
                   .arg("lights", lights);
             });
  std::vector<double> kept(luminances.size());
  for (const MicroLeafLight& light : lights.download()) {
    REQUIRE(light.direction.w == test::relative(sum, 1e-6));
    REQUIRE(light.color.y == test::relative(1, 1e-6));  // irradiance over its luminance
    ++kept[static_cast<size_t>(light.direction.x)];
  }
  for (size_t k = 0; k < kept.size(); ++k) {
    CAPTURE(k);
    const double share = double{luminances[k] / sum};
    CHECK(kept[k] / leaves == test::within(share, 5 * std::sqrt(share * (1 - share) / leaves)));
  }
}
