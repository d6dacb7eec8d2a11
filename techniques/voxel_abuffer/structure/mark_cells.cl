// SPDX-License-Identifier: Apache-2.0
// Which cells of voxels the exact fragments of an axis touch.
#include "voxel_abuffer/structure/cell_marks.clh"
#include "voxel_abuffer/structure/turned_cells.clh"

// Marks of a voxel column, and which of its voxels have any.
typedef struct AbufferTouchedCells {
  ulong slabs[ABUFFER_SLABS];
  uchar touched[ABUFFER_GRID_VOXELS];
} AbufferTouchedCells;

// Marks a fragment's cells. per_step: cells per step of depth, times 2^32, rounded up: the quotient of what has
// 16 bits is exact.
static void abuffer_mark_interval(AbufferTouchedCells* marks, ulong section, uint interval, ulong per_step,
                                  uint last_slab) {
  const uint near = interval & 0xffffu, far = (uint)ABUFFER_DEPTH_LAST - (interval >> 16);
  const uint first = min((uint)(near * per_step >> 32), last_slab), last = min((uint)(far * per_step >> 32), last_slab);
  // Most fragments touch one slab or two, in no order that a processor could foresee.
  marks->slabs[first] |= section;
  marks->slabs[last] |= section;
  marks->touched[first >> 3] = 1;
  marks->touched[last >> 3] = 1;
  for (uint slab = first + 1u; slab < last; ++slab) {
    marks->slabs[slab] |= section;
    marks->touched[slab >> 3] = 1;
  }
}

// Gives a voxel its marks. If it has no cells, what lies there is near a triangle only.
static void abuffer_give_marks(AbufferTouchedCells* marks, uint z, uint word, uint axis, __global ulong* cells) {
  const ulong8 slices = abuffer_take_slabs(marks->slabs, z);
  marks->touched[z] = 0;
  if (!(word & ABUFFER_EXACT(axis))) return;
  const uint block = (word >> ABUFFER_CELLS_SHIFT) + popcount(word & (ABUFFER_EXACT(axis) - 1u));
  __global ulong* words = cells + block * ABUFFER_CELL_WORDS;
  vstore8(slices, axis, words);
  vstore8(abuffer_turn_on(slices), abuffer_axis_x(axis), words);
  vstore8(abuffer_turn_back(slices), abuffer_axis_y(axis), words);
}

// One row of voxel columns per work-item: no two write to one voxel.
__kernel void abuffer_mark_cells_of_row(__global const AbufferGrid* abuffer_grid, __global const uint* abuffer_start,
                                        __global const uint* abuffer_depths, __global const uint* abuffer_counts,
                                        uint axis, uint first, uint capacity, __global const uint* abuffer_voxels,
                                        uint cell_capacity, __global ulong* abuffer_cells, DEALT_ROW_PARAMETER) {
  const AbufferGrid grid = abuffer_grid[0];
  const uint edge = grid.voxels.w, columns = abuffer_component(grid.voxels, abuffer_axis_x(axis));
  const uint depth = abuffer_component(grid.voxels, axis);
  const uint steps = (uint)ABUFFER_DEPTH_STEPS * edge / ABUFFER_CELLS;  // of a cell
  const ulong per_step = 0xfffffffful / steps + 1ul;
  const uint row = DEALT_ROW;
  if (row >= abuffer_component(grid.voxels, abuffer_axis_y(axis))) return;
  if (abuffer_counts[first + axis + 1u] > capacity || abuffer_counts[ABUFFER_COUNT_CELLS] > cell_capacity) return;
  AbufferSections sections;
  abuffer_find_sections(edge, &sections);
  AbufferTouchedCells marks;
  abuffer_clear_slabs(marks.slabs, depth);
  for (uint z = 0u; z < depth + 7u; ++z) marks.touched[min(z, ABUFFER_GRID_VOXELS - 1u)] = 0;
  __global const uint* start = abuffer_start + axis * grid.bricks.w + row * columns * edge * edge;
  for (uint voxel = 0u; voxel < columns; ++voxel) {
    // Pass over voxel columns without fragments.
    if (start[0] == start[edge * edge]) {
      start += edge * edge;
      continue;
    }
    // Mark the cells of every fragment, column by column.
    for (uint y = 0u; y < edge; ++y)
      for (uint x = 0u; x < edge; ++x, ++start) {
        if (start[0] == start[1]) continue;
        const ulong section = abuffer_cell_section(&sections, x, y);
        for (uint i = start[0]; i < start[1]; ++i)
          abuffer_mark_interval(&marks, section, abuffer_depths[i], per_step, 8u * depth - 1u);
      }
    for (uint z = 0u; z < depth; ++z) {
      if (!(z & 7u) && as_ulong(vload8(0, marks.touched + z)) == 0ul)
        z += 7u;
      else if (marks.touched[z])
        abuffer_give_marks(&marks, z, abuffer_voxels[abuffer_voxel(grid.bricks, abuffer_voxel_of(axis, voxel, row, z))],
                           axis, abuffer_cells);
    }
  }
}
