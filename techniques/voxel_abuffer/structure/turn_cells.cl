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

// From slices across the axis of a block's fragments those across the other two.
__kernel void abuffer_turn_cells(__global const uint* abuffer_voxels, uint count, __global const uint* abuffer_counts,
                                 uint cell_capacity, __global ulong* abuffer_cells) {
  const uint i = get_global_id(0);
  if (i >= count || abuffer_counts[ABUFFER_COUNT_CELLS] > cell_capacity) return;
  const uint word = abuffer_voxels[i];
  __global ulong* cells = abuffer_cells + (word >> ABUFFER_CELLS_SHIFT) * ABUFFER_CELL_WORDS;
  for (uint axis = 0u; axis < 3u; ++axis) {
    if (!(word & ABUFFER_EXACT(axis))) continue;
    ulong slices[8], turned[8];  // bit 8 y + x of slice z; bit 8 x + y of it
    for (uint z = 0u; z < 8u; ++z) {
      slices[z] = cells[8u * axis + z];
      turned[z] = abuffer_transpose(slices[z]);
    }
    for (uint j = 0u; j < 8u; ++j) {
      cells[8u * abuffer_axis_x(axis) + j] = abuffer_gather_bytes(turned, j);                     // bit 8 z + y of x
      cells[8u * abuffer_axis_y(axis) + j] = abuffer_transpose(abuffer_gather_bytes(slices, j));  // bit 8 x + z of y
    }
    cells += ABUFFER_CELL_WORDS;
  }
}
