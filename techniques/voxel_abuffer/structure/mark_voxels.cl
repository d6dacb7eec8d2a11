// SPDX-License-Identifier: Apache-2.0
// Which voxels triangles touch, and which bricks have such voxels. Fragments alone miss some (Hu et al. 2014 voxelise
// by them).
#include "lucarium/shared/scene_types.h"
#include "voxel_abuffer/structure/touches.clh"

// Bits that a word has already; those that it gets meanwhile may be missed. An atomic operation for interpreters that
// take any other look for a race.
#ifdef LAYERED_PORTABLE
#define ABUFFER_SEEN(word) atomic_or(word, 0u)
#else
#define ABUFFER_SEEN(word) (*(word))
#endif

__kernel void abuffer_mark_voxels(__global const AbufferGrid* abuffer_grid, __global const uchar* abuffer_classes,
                                  __global const float* abuffer_triangles, volatile __global uint* abuffer_voxels) {
  const uint i = get_global_id(0);
  const AbufferGrid grid = abuffer_grid[0];
  if (i >= grid.triangles || !(abuffer_classes[i] & ABUFFER_OCCUPIED)) return;
  __global const float* words = abuffer_triangles + i * ABUFFER_TRIANGLE_WORDS;
  float4 p[3];
  for (uint k = 0u; k < 3u; ++k) p[k] = abuffer_position(&grid, (float4)(vload3(k, words), 0.0f));
  const float pad = (abuffer_classes[i] & ABUFFER_PARITY ? ABUFFER_PARITY_PAD : ABUFFER_VOXEL_PAD) + grid.slack,
              edge = (float)grid.voxels.w, half_edge = 0.5f * edge + pad;
  const float4 low = fmin(p[0], fmin(p[1], p[2])) - pad, high = fmax(p[0], fmax(p[1], p[2])) + pad;
  const float4 sum = low + high;
  if (!(fabs(sum.x) + fabs(sum.y) + fabs(sum.z) < 1e15f)) return;  // not finite, or beyond what rays can hit
  const int4 first = abuffer_clamped_voxel(&grid, low), last = abuffer_clamped_voxel(&grid, high);
  const uint bits = abuffer_classes[i] & ABUFFER_OCCUPIED;
  // Along one axis only it touches all that its bounds do.
  const int axes = (first.x != last.x) + (first.y != last.y) + (first.z != last.z);
  for (int z = first.z; z <= last.z; ++z)
    for (int y = first.y; y <= last.y; ++y)
      for (int x = first.x; x <= last.x; ++x) {
        const float4 center = ((float4)((float)x, (float)y, (float)z, 0.0f) + 0.5f) * edge;
        volatile __global uint* word =
            abuffer_voxels + abuffer_voxel(grid.bricks, (uint4)((uint)x, (uint)y, (uint)z, 0u));
        if ((ABUFFER_SEEN(word) & bits) == bits) continue;  // by another triangle, as most are
        if (axes < 2 || abuffer_touches(p, center, half_edge)) atomic_or(word, bits);
      }
}

__kernel void abuffer_count_cells(__global const uint* abuffer_voxels, uint count, __global uint* abuffer_cell_first) {
  const uint i = get_global_id(0);
  if (i < count) abuffer_cell_first[i] = popcount(abuffer_voxels[i] & ABUFFER_EXACT_AXES);
}

__kernel void abuffer_keep_cell_count(__global const uint* abuffer_cell_count, __global uint* abuffer_counts) {
  abuffer_counts[ABUFFER_COUNT_CELLS] = abuffer_cell_count[0];
}

// A bit for each occupied voxel of a brick, and the place of each voxel's cells (abuffer_cell_first: scanned).
__kernel void abuffer_mark_bricks(__global const uint* abuffer_cell_first, uint count, __global uint* abuffer_voxels,
                                  __global ulong* abuffer_bricks) {
  const uint brick = get_global_id(0);
  if (brick >= count) return;
  ulong bits = 0ul;
  for (uint i = 0u; i < 64u; ++i) {
    const uint voxel = brick * 64u + i, word = abuffer_voxels[voxel];
    bits |= (ulong)((word & ABUFFER_OCCUPIED) != 0u) << i;
    abuffer_voxels[voxel] = word | abuffer_cell_first[voxel] << ABUFFER_CELLS_SHIFT;
  }
  abuffer_bricks[brick] = bits;
}

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
