// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/texel_sides/side_points.clh"

// Work-item i: the points of a texel side are reached where bit k of i is set. turns: of each of the points, how many
// rounds it gets of those whose number has the remainder 0 ... 7.
kernel void count_turns(const uint rounds, global uint* turns) {
  const uint i = get_global_id(0);
  uint levels = 0u;
  for (uint k = 0u; k < SIDE_POINTS; ++k) levels |= (i >> k & 1u) << 4u * k;
  for (uint r = 0u; r < rounds; ++r) ++turns[8u * (SIDE_POINTS * i + side_point(levels, r)) + r % 8u];
}
