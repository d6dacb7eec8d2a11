// SPDX-License-Identifier: Apache-2.0
// How long the lists of columns are: the longest, and how many columns have any fragments.
#include "voxel_abuffer/structure/grid.clh"

// Every work-item looks at a share of the columns of one axis (second dimension). first, capacity: as of the passes
// that make the lists.
__kernel void abuffer_measure_lists(__global const AbufferGrid* abuffer_grid, __global const uint* abuffer_start,
                                    uint first, uint capacity, __global uint* abuffer_counts) {
  const AbufferGrid grid = abuffer_grid[0];
  const uint axis = get_global_id(1);
  const uint columns = abuffer_component(grid.voxels, abuffer_axis_x(axis)) *
                       abuffer_component(grid.voxels, abuffer_axis_y(axis)) * grid.voxels.w * grid.voxels.w;
  if (abuffer_counts[first + 3u] > capacity) return;
  __global const uint* start = abuffer_start + axis * grid.bricks.w;
  uint longest = 0u, filled = 0u;
  for (uint i = get_global_id(0); i < columns; i += get_global_size(0)) {
    const uint length = start[i + 1u] - start[i];
    longest = max(longest, length);
    filled += length > 0u ? 1u : 0u;
  }
  atomic_max(abuffer_counts + ABUFFER_COUNT_LONGEST, longest);
  atomic_add(abuffer_counts + ABUFFER_COUNT_FILLED, filled);
}
