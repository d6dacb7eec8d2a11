// SPDX-License-Identifier: Apache-2.0
// Which cells of voxels the exact fragments of an axis touch.
#include "voxel_abuffer/structure/grid.clh"

// Coordinates of the cells that a pixel of a voxel covers: first and last in bits 0–7 and 8–15.
static uint abuffer_cells_of_pixel(uint pixel, uint edge) {
  return (8u * pixel / edge) | ((8u * pixel + 7u) / edge) << 8;
}

// Cells (bits 8 y + x) of a column's cross section.
static ulong abuffer_cell_section(uint x, uint y) {
  const ulong row = (2ul << (x >> 8)) - (1ul << (x & 255u));
  ulong section = 0ul;
  for (uint i = y & 255u; i <= y >> 8; ++i) section |= row << (8u * i);
  return section;
}

// Marks the cells of one depth interval, in the slices across `axis` only: abuffer_turn_cells() makes the others.
// per_step: cells per step of depth; adding a half makes the float quotient's integer part exact.
static void abuffer_mark_cells(const AbufferGrid* grid, __global const uint* voxels, __global ulong* cells, uint axis,
                               uint voxel_x, uint voxel_y, ulong section, uint interval, float per_step) {
  const uint last_slab = 8u * abuffer_component(grid->voxels, axis) - 1u;
  const uint near = interval & 0xffffu, far = (uint)ABUFFER_DEPTH_LAST - (interval >> 16);
  const uint first = min((uint)(((float)near + 0.5f) * per_step), last_slab);
  const uint last = min((uint)(((float)far + 0.5f) * per_step), last_slab);
  for (uint slab = first; slab <= last; ++slab) {
    const uint word = voxels[abuffer_voxel(grid->bricks, abuffer_voxel_of(axis, voxel_x, voxel_y, slab >> 3))];
    if (!(word & ABUFFER_EXACT(axis))) continue;  // near it only
    const uint block = (word >> ABUFFER_CELLS_SHIFT) + popcount(word & (ABUFFER_EXACT(axis) - 1u));
    cells[block * ABUFFER_CELL_WORDS + 8u * axis + (slab & 7u)] |= section;
  }
}

// One row of voxel columns per work-item: no two write to one voxel.
__kernel void abuffer_mark_cells_of_row(__global const AbufferGrid* abuffer_grid, __global const uint* abuffer_start,
                                        __global const uint* abuffer_depths, __global const uint* abuffer_counts,
                                        uint axis, uint first, uint capacity, __global const uint* abuffer_voxels,
                                        uint cell_capacity, __global ulong* abuffer_cells) {
  const AbufferGrid grid = abuffer_grid[0];
  const uint edge = grid.voxels.w, columns = abuffer_component(grid.voxels, abuffer_axis_x(axis));
  const float per_step = 8.0f / ((float)edge * ABUFFER_DEPTH_STEPS);
  const uint row = get_global_id(0);
  if (row >= abuffer_component(grid.voxels, abuffer_axis_y(axis))) return;
  if (abuffer_counts[first + axis + 1u] > capacity || abuffer_counts[ABUFFER_COUNT_CELLS] > cell_capacity) return;
  __global const uint* start = abuffer_start + axis * grid.bricks.w + row * columns * edge * edge;
  for (uint voxel = 0u; voxel < columns; ++voxel)
    for (uint y = 0u; y < edge; ++y)
      for (uint x = 0u; x < edge; ++x, ++start) {
        const ulong section = abuffer_cell_section(abuffer_cells_of_pixel(x, edge), abuffer_cells_of_pixel(y, edge));
        for (uint i = start[0]; i < start[1]; ++i)
          abuffer_mark_cells(&grid, abuffer_voxels, abuffer_cells, axis, voxel, row, section, abuffer_depths[i],
                             per_step);
      }
}
