// SPDX-License-Identifier: Apache-2.0
// services/texel_sides/side_points.clh: the points of texel sides get equal turns.
#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <numeric>

#include "kernel_fixture.h"
#include "lucarium/shared/texel_sides.h"

using namespace lucarium;

TEST_CASE("points of a texel side that light can reach get as many rounds each, of all eighths of the Sobol points") {
  // Every pattern is over after 36, 40, 56 or 8 rounds.
  constexpr uint32_t rounds = 5040, patterns = 1u << SIDE_POINTS;
  const auto turns = test::test_buffer(std::vector<uint32_t>(size_t{patterns} * SIDE_POINTS * 8));
  test::run_kernel(test::kernel_program("side_points"), "count_turns", patterns, 1,
                   [&](PassBuilder& pass) { pass.arg("rounds", rounds).arg("turns", turns); });
  const std::vector<uint32_t> found = turns.download();
  for (uint32_t pattern = 0; pattern < patterns; ++pattern) {
    // Where none is reached, all serve.
    const uint32_t reached = pattern == 0 ? (1u << SIDE_POINTS) - 1 : pattern;
    CAPTURE(reached);
    for (uint32_t k = 0; k < SIDE_POINTS; ++k) {
      CAPTURE(k);
      const auto first = found.begin() + 8 * (SIDE_POINTS * pattern + k);
      const bool is_reached = reached >> k & 1u;
      CHECK(std::accumulate(first, first + 8, 0u) ==
            (is_reached ? rounds / static_cast<uint32_t>(std::popcount(reached)) : 0u));
      if (is_reached) CHECK(*std::min_element(first, first + 8) > 0);
    }
  }
}
