// SPDX-License-Identifier: Apache-2.0
// Which voxels hold fragments: all that Hu et al. 2014 (section 3.1) know of a voxel. A surface that crosses a voxel
// beside the centres of its pixels is missed there: of the voxels that triangles touch 1.5 % at N = 64.
#include "voxel_abuffer/structure/grid.clh"

// Where a fragment lies along its axis [pixels]; exact ones: the middle of their interval.
static float abuffer_fragment_depth(uint word, bool exact) {
  if (!exact) return as_float(word);
  const uint near = word & 0xffffu, far = (uint)ABUFFER_DEPTH_LAST - (word >> 16);
  return (float)(near + far) * (0.5f / ABUFFER_DEPTH_STEPS);
}

// One row of voxel columns per work-item: no two write to one voxel. bits: what the voxels' words get,
// ABUFFER_EXACT(axis) or ABUFFER_PARITY.
__kernel void abuffer_mark_fragment_voxels(__global const AbufferGrid* abuffer_grid, __global const uint* abuffer_start,
                                           __global const uint* abuffer_depths, __global const uint* abuffer_counts,
                                           uint axis, uint first, uint capacity, uint bits,
                                           __global uint* abuffer_voxels, DEALT_ROW_PARAMETER) {
  const AbufferGrid grid = abuffer_grid[0];
  const uint edge = grid.voxels.w, columns = abuffer_component(grid.voxels, abuffer_axis_x(axis));
  const uint last = abuffer_component(grid.voxels, axis) - 1u, row = DEALT_ROW;
  if (row >= abuffer_component(grid.voxels, abuffer_axis_y(axis)) || abuffer_counts[first + axis + 1u] > capacity)
    return;
  __global const uint* start = abuffer_start + axis * grid.bricks.w + row * columns * edge * edge;
  for (uint voxel = 0u; voxel < columns; ++voxel, start += edge * edge)
    for (uint i = start[0]; i < start[edge * edge]; ++i) {
      const float depth = abuffer_fragment_depth(abuffer_depths[i], bits != ABUFFER_PARITY);
      const uint z = min((uint)fmax(depth / (float)edge, 0.0f), last);
      abuffer_voxels[abuffer_voxel(grid.bricks, abuffer_voxel_of(axis, voxel, row, z))] |= bits;
    }
}
