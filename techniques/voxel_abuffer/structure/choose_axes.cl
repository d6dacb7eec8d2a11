// SPDX-License-Identifier: Apache-2.0
// Which A-buffer a voxel is searched in, for parity.
#include "voxel_abuffer/structure/grid.clh"

#define ABUFFER_CANCELS 64u

// The axis of the largest number; 3 where all are 0.
static uint abuffer_largest_of(const uint* sizes) {
  uint axis = 3u, largest = 0u;
  for (uint k = 0u; k < 3u; ++k)
    if (sizes[k] > largest) {
      largest = sizes[k];
      axis = k;
    }
  return axis;
}

// The axis by whose columns a voxel is searched for parity: that of the largest component of the sum of |n| over the
// surface in it, or, with `average`, of the average normal (Hu et al. 2014, section 3.1); any where there are no
// fragments. Of surfaces that face each other the average says nothing (two planes with a gap between them have none):
// the sum of |n| decides where less than a part in ABUFFER_CANCELS of it is left.
__kernel void abuffer_choose_axes(__global const int2* abuffer_facing, uint count, uint average,
                                  __global uint* abuffer_voxels) {
  const uint i = get_global_id(0);
  if (i >= count || !(abuffer_voxels[i] & ABUFFER_PARITY)) return;
  uint absolute[3], sum[3];
  for (uint k = 0u; k < 3u; ++k) {
    const int2 facing = abuffer_facing[3u * i + k];
    absolute[k] = (uint)facing.x;
    sum[k] = abs(facing.y);
  }
  const uint by_size = abuffer_largest_of(absolute), by_average = abuffer_largest_of(sum);
  const bool cancels = by_average == 3u || sum[by_average] <= absolute[by_size] / ABUFFER_CANCELS;
  abuffer_voxels[i] |= (average && !cancels ? by_average : by_size) << ABUFFER_AXIS_SHIFT;
}
