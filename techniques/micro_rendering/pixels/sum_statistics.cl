// SPDX-License-Identifier: Apache-2.0
// Statistics of all gathers, for the counters.
#include "lucarium/shared/gbuffer.h"
#include "lucarium/sub_image.clh"
#include "micro_rendering/shared/micro_types.h"

// Sums over runs of `run` pixels of a sub-image.
__kernel void sum_statistics(__global const GBufferPoint* restrict points, const SubImage sub, uint run,
                             __global const MicroStatistics* restrict statistics, uint pixels, uint sides,
                             __global MicroStatistics* restrict sums) {
  const uint first = get_global_id(0) * run, end = min(first + run, sub.width * sub.height);
  MicroStatistics sum = {0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u};
  for (uint i = first; i < end; ++i) {
    const uint pixel = sub_image_pixel(sub, i);
    if (points[pixel].state != LUCARIUM_GBUFFER_SURFACE) continue;
    for (uint side = 0; side < sides; ++side) {
      const MicroStatistics s = statistics[pixel + side * pixels];
      sum.visits += s.visits;
      sum.splats += s.splats;
      sum.listed += s.listed;
      sum.disc_tests += s.disc_tests;
      sum.holes += s.holes;
      sum.flushes += s.flushes;
      sum.levels += s.listed > 0u;
      sum.uneven += s.visits > 0u;
    }
  }
  sums[get_global_id(0)] = sum;
}
