// SPDX-License-Identifier: Apache-2.0
// Components whose fronts and backs do not balance, which have no inside after all.
#include "voxel_abuffer/structure/grid.clh"

// Columns in which fronts and backs do not cancel: of meshes whose seams a deformation opened. abuffer_unbalanced: per
// component, set to 1; behind them the number of such columns.
__kernel void abuffer_check_columns(__global const AbufferGrid* abuffer_grid, __global const uint* abuffer_start,
                                    __global const uint* abuffer_fragments, __global const uint* abuffer_component_of,
                                    __global const uint* abuffer_counts, uint first, uint capacity, uint components,
                                    volatile __global uint* abuffer_unbalanced) {
  const AbufferGrid grid = abuffer_grid[0];
  const uint column = get_global_id(0), axis = get_global_id(1);
  const uint columns = abuffer_component(grid.voxels, abuffer_axis_x(axis)) *
                       abuffer_component(grid.voxels, abuffer_axis_y(axis)) * grid.voxels.w * grid.voxels.w;
  if (column >= columns || abuffer_counts[first + 3u] > capacity) return;
  const uint begin = abuffer_start[axis * grid.bricks.w + column],
             end = abuffer_start[axis * grid.bricks.w + column + 1u];
  int balance = 0;
  for (uint i = begin; i < end; ++i) balance += abuffer_fragments[i] >> 31 ? -1 : 1;
  if (balance == 0) return;
  atomic_inc(abuffer_unbalanced + components);
  // Which components: those that do not balance by themselves.
  for (uint i = begin; i < end; ++i) {
    const uint component = abuffer_component_of[abuffer_fragments[i] & 0x7fffffffu];
    int own = 0;
    for (uint j = begin; j < end; ++j)
      if (abuffer_component_of[abuffer_fragments[j] & 0x7fffffffu] == component)
        own += abuffer_fragments[j] >> 31 ? -1 : 1;
    if (own != 0) abuffer_unbalanced[component] = 1u;
  }
}
