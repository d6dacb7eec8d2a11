// SPDX-License-Identifier: Apache-2.0
// Cells as slices across all three axes, from those across one (mark_cells.cl).
#include "voxel_abuffer/structure/grid.clh"

// Bits 8 i + j exchanged with 8 j + i (Warren, "Hacker's Delight", 2nd edition, 2012, figure 7-3).
static ulong abuffer_transpose(ulong x) {
  ulong t = (x ^ (x >> 7)) & 0x00aa00aa00aa00aaul;
  x ^= t ^ (t << 7);
  t = (x ^ (x >> 14)) & 0x0000cccc0000ccccul;
  x ^= t ^ (t << 14);
  t = (x ^ (x >> 28)) & 0x00000000f0f0f0f0ul;
  return x ^ t ^ (t << 28);
}

// Byte `from` of eight words as the bytes of one.
static ulong abuffer_gather_bytes(const ulong* words, uint from) {
  ulong result = 0ul;
  for (uint i = 0u; i < 8u; ++i) result |= (words[i] >> (8u * from) & 255ul) << (8u * i);
  return result;
}

// From slices across one axis (bit 8 y + x of slice z) those across the other two, added to `result`, a cell block.
static void abuffer_turn(const ulong* slices, uint axis, ulong* result) {
  ulong turned[8];  // bit 8 x + y of slice z
  for (uint z = 0u; z < 8u; ++z) turned[z] = abuffer_transpose(slices[z]);
  for (uint j = 0u; j < 8u; ++j) {
    result[8u * axis + j] |= slices[j];
    result[8u * abuffer_axis_x(axis) + j] |= abuffer_gather_bytes(turned, j);                     // bit 8 z + y of x
    result[8u * abuffer_axis_y(axis) + j] |= abuffer_transpose(abuffer_gather_bytes(slices, j));  // bit 8 x + z of y
  }
}

// Completes one block, of slices across `axis`, or across each where it is 3.
static void abuffer_turn_block(__global ulong* cells, uint axis) {
  ulong slices[ABUFFER_CELL_WORDS], result[ABUFFER_CELL_WORDS];
  for (uint j = 0u; j < ABUFFER_CELL_WORDS; ++j) {
    slices[j] = cells[j];
    result[j] = 0ul;
  }
  for (uint k = 0u; k < 3u; ++k)
    if (axis == 3u || axis == k) abuffer_turn(slices + 8u * k, k, result);
  for (uint j = 0u; j < ABUFFER_CELL_WORDS; ++j) cells[j] = result[j];
}

__kernel void abuffer_turn_cells(__global const uint* abuffer_voxels, uint count, uint walls,
                                 __global const uint* abuffer_counts, uint cell_capacity,
                                 __global ulong* abuffer_cells) {
  const uint i = get_global_id(0);
  if (i >= count || abuffer_counts[ABUFFER_COUNT_CELLS] > cell_capacity) return;
  const uint word = abuffer_voxels[i];
  __global ulong* cells = abuffer_cells + (word >> ABUFFER_CELLS_SHIFT) * ABUFFER_CELL_WORDS;
  for (uint axis = 0u; axis < 3u; ++axis) {
    if (!(word & ABUFFER_EXACT(axis))) continue;
    abuffer_turn_block(cells, axis);
    cells += ABUFFER_CELL_WORDS;
  }
  if (walls && (word & ABUFFER_PARITY)) abuffer_turn_block(cells, word >> ABUFFER_AXIS_SHIFT & 3u);
}
