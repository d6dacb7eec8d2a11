// SPDX-License-Identifier: Apache-2.0
// Which cells of voxels the exact fragments of an axis touch.
#include "voxel_abuffer/structure/cell_marks.clh"

// Where the cells of each voxel along a voxel column begin that are slices across `axis`.
static void abuffer_cells_of_column(const AbufferGrid* grid, __global const uint* voxels, uint axis, uint voxel_x,
                                    uint voxel_y, uint depth, uint* places) {
  for (uint z = 0u; z < depth; ++z) {
    const uint word = voxels[abuffer_voxel(grid->bricks, abuffer_voxel_of(axis, voxel_x, voxel_y, z))];
    const uint block = (word >> ABUFFER_CELLS_SHIFT) + popcount(word & (ABUFFER_EXACT(axis) - 1u));
    places[z] = word & ABUFFER_EXACT(axis) ? block * ABUFFER_CELL_WORDS + 8u * axis : ABUFFER_NO_CELLS;
  }
}

// Marks the cells of one depth interval. per_step: cells per step of depth; adding a half makes the float quotient's
// integer part exact. What lies in no voxel with cells is near the triangle only.
static void abuffer_mark_interval(__global ulong* cells, const uint* places, ulong section, uint interval,
                                  float per_step, uint last_slab) {
  const uint near = interval & 0xffffu, far = (uint)ABUFFER_DEPTH_LAST - (interval >> 16);
  const uint first = min((uint)(((float)near + 0.5f) * per_step), last_slab);
  const uint last = min((uint)(((float)far + 0.5f) * per_step), last_slab);
  abuffer_mark_slabs(cells, places, section, first, last);
}

// One row of voxel columns per work-item: no two write to one voxel.
__kernel void abuffer_mark_cells_of_row(__global const AbufferGrid* abuffer_grid, __global const uint* abuffer_start,
                                        __global const uint* abuffer_depths, __global const uint* abuffer_counts,
                                        uint axis, uint first, uint capacity, __global const uint* abuffer_voxels,
                                        uint cell_capacity, __global ulong* abuffer_cells) {
  const AbufferGrid grid = abuffer_grid[0];
  const uint edge = grid.voxels.w, columns = abuffer_component(grid.voxels, abuffer_axis_x(axis));
  const uint depth = abuffer_component(grid.voxels, axis);
  const float per_step = 8.0f / ((float)edge * ABUFFER_DEPTH_STEPS);
  const uint row = get_global_id(0);
  if (row >= abuffer_component(grid.voxels, abuffer_axis_y(axis))) return;
  if (abuffer_counts[first + axis + 1u] > capacity || abuffer_counts[ABUFFER_COUNT_CELLS] > cell_capacity) return;
  uint places[ABUFFER_MAX_VOXELS];
  __global const uint* start = abuffer_start + axis * grid.bricks.w + row * columns * edge * edge;
  for (uint voxel = 0u; voxel < columns; ++voxel) {
    // Pass over voxel columns without fragments.
    if (start[0] == start[edge * edge]) {
      start += edge * edge;
      continue;
    }
    abuffer_cells_of_column(&grid, abuffer_voxels, axis, voxel, row, depth, places);
    // Mark the cells of every fragment, column by column.
    AbufferCellSpan y_cells = abuffer_first_span(edge);
    for (uint y = 0u; y < edge; ++y, abuffer_next_span(&y_cells, edge)) {
      AbufferCellSpan x_cells = abuffer_first_span(edge);
      for (uint x = 0u; x < edge; ++x, ++start, abuffer_next_span(&x_cells, edge)) {
        if (start[0] == start[1]) continue;
        const ulong section = abuffer_cell_section(x_cells, y_cells);
        for (uint i = start[0]; i < start[1]; ++i)
          abuffer_mark_interval(abuffer_cells, places, section, abuffer_depths[i], per_step, 8u * depth - 1u);
      }
    }
  }
}
