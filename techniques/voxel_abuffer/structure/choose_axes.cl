// SPDX-License-Identifier: Apache-2.0
// Which A-buffer a voxel is searched in, for parity.
#include "voxel_abuffer/structure/grid.clh"

// The axis by whose columns a voxel is searched for parity: that of the largest component of the sum of |n| over the
// surface in it, or, with `average`, of the average normal (Hu et al. 2014, section 3.1); any where there are no
// fragments.
__kernel void abuffer_choose_axes(__global const int2* abuffer_facing, uint count, uint average,
                                  __global uint* abuffer_voxels) {
  const uint i = get_global_id(0);
  if (i >= count || !(abuffer_voxels[i] & ABUFFER_PARITY)) return;
  uint axis = 3u;
  int largest = 0;
  for (uint k = 0u; k < 3u; ++k) {
    const int2 facing = abuffer_facing[3u * i + k];
    const int size = average ? (int)abs(facing.y) : facing.x;
    if (size > largest) {
      largest = size;
      axis = k;
    }
  }
  abuffer_voxels[i] |= axis << ABUFFER_AXIS_SHIFT;
}
