// SPDX-License-Identifier: Apache-2.0
// Completes the cell blocks of parity, whose slices across one axis, or all three, mark_walls.cl makes.
#include "voxel_abuffer/structure/turned_cells.clh"

__kernel void abuffer_turn_cells(__global const uint* abuffer_voxels, uint count, __global const uint* abuffer_counts,
                                 uint cell_capacity, __global ulong* abuffer_cells) {
  const uint i = get_global_id(0);
  if (i >= count || abuffer_counts[ABUFFER_COUNT_CELLS] > cell_capacity) return;
  const uint word = abuffer_voxels[i], axis = word >> ABUFFER_AXIS_SHIFT & 3u;
  if (!(word & ABUFFER_PARITY)) return;
  const uint block = (word >> ABUFFER_CELLS_SHIFT) + popcount(word & ABUFFER_EXACT_AXES);
  __global ulong* cells = abuffer_cells + block * ABUFFER_CELL_WORDS;
  ulong8 result[3] = {0ul, 0ul, 0ul};
  for (uint k = 0u; k < 3u; ++k) {
    if (axis != 3u && axis != k) continue;
    const ulong8 slices = vload8(k, cells);
    result[k] |= slices;
    result[abuffer_axis_x(k)] |= abuffer_turn_on(slices);
    result[abuffer_axis_y(k)] |= abuffer_turn_back(slices);
  }
  for (uint k = 0u; k < 3u; ++k) vstore8(result[k], k, cells);
}
