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

// Cell blocks of each brick. kinds: of the voxels' bits those that have cells.
__kernel void abuffer_count_cells(__global const uint* abuffer_voxels, uint count, uint kinds,
                                  __global uint* abuffer_cell_first) {
  const uint brick = get_global_id(0);
  if (brick >= count) return;
  uint16 sum = (uint16)(0u);
  for (uint i = 0u; i < 4u; ++i) sum += popcount(vload16(4u * brick + i, abuffer_voxels) & kinds);
  const uint8 eight = sum.lo + sum.hi;
  const uint4 four = eight.lo + eight.hi;
  abuffer_cell_first[brick] = four.x + four.y + four.z + four.w;
}

__kernel void abuffer_keep_cell_count(__global const uint* abuffer_cell_count, __global uint* abuffer_counts) {
  abuffer_counts[ABUFFER_COUNT_CELLS] = abuffer_cell_count[0];
}

// A bit for each occupied voxel of a brick, and the place of each voxel's cells (abuffer_cell_first: scanned).
__kernel void abuffer_mark_bricks(__global const uint* abuffer_cell_first, uint count, uint kinds,
                                  __global uint* abuffer_voxels, __global ulong* abuffer_bricks) {
  const uint brick = get_global_id(0);
  if (brick >= count) return;
  uint cell = abuffer_cell_first[brick];
  ulong bits = 0ul;
  for (uint i = 0u; i < 64u; ++i) {
    const uint voxel = brick * 64u + i, word = abuffer_voxels[voxel];
    if (!(word & ABUFFER_OCCUPIED)) continue;
    bits |= 1ul << i;
    abuffer_voxels[voxel] = word | cell << ABUFFER_CELLS_SHIFT;
    cell += popcount(word & kinds);
  }
  abuffer_bricks[brick] = bits;
}

// How many empty bricks a cube has that begins with a brick and grows towards an octant, at most 255; 0: the brick is
// not empty (distances within octants: Semwal and Kvarnstrom, "Directed Safe Zones and the Dual Extent Algorithms for
// Efficient Grid Traversal during Ray Tracing", 1997). A work-item per octant; bits 0, 1, 2: towards higher x, y, z.
// Word `count` and above of the bricks hold a byte for each octant.
__kernel void abuffer_mark_empty(__global const AbufferGrid* abuffer_grid, __global ulong* abuffer_bricks) {
  const uint octant = get_global_id(0);
  const int4 size = convert_int4(abuffer_grid[0].bricks);
  const int3 up = (int3)((int)(octant & 1u), (int)(octant >> 1 & 1u), (int)(octant >> 2));
  const int3 side = 2 * up - 1, stride = side * (int3)(1, size.x, size.x * size.y);
  const int count = size.x * size.y * size.z;
  __global uchar* edges = (__global uchar*)(abuffer_bricks + count);
  for (int k = 0; k < size.z; ++k)
    for (int j = 0; j < size.y; ++j) {
      // The bricks towards the octant come first; none is behind the first ones.
      const int y = up.y ? size.y - 1 - j : j, z = up.z ? size.z - 1 - k : k;
      int brick = (z * size.y + y) * size.x + (up.x ? size.x - 1 : 0), before = 254;
      for (int i = 0; i < size.x; ++i, brick -= side.x) {
        __global uchar* edge = edges + 8 * brick + (int)octant;
        int least = 254;
        if (j) least = min(least, (int)edge[8 * stride.y]);
        if (k) least = min(least, (int)edge[8 * stride.z]);
        if (j && k) least = min(least, (int)edge[8 * (stride.y + stride.z)]);
        const int own = abuffer_bricks[brick] ? 0 : min(least, before) + 1;
        *edge = (uchar)own;
        before = min(least, own);  // what the next one has of this brick and those beside it
      }
    }
}

// Of each voxel and octant, how many voxels a cube has that begins with it, grows towards the octant and holds nothing
// for parity, at most 255; 0: the voxel itself does (as abuffer_mark_empty() has them for bricks). Behind the bricks'
// two words each, all voxels of an octant after those of the one before, as abuffer_voxel() orders them. A work-item
// per octant; bits 0, 1, 2: towards higher x, y, z. Outside the grid all is empty.
__kernel void abuffer_mark_reaches(__global const AbufferGrid* abuffer_grid, __global const uint* abuffer_voxels,
                                   __global ulong* abuffer_bricks) {
  const uint octant = get_global_id(0);
  const int4 bricks = convert_int4(abuffer_grid[0].bricks), size = 4 * bricks;
  const int count = bricks.x * bricks.y * bricks.z;
  const bool up_x = octant & 1u, up_y = octant & 2u, up_z = octant & 4u;
  __global uchar* reaches = (__global uchar*)(abuffer_bricks + 2 * count) + 64 * count * (int)octant;
  for (int k = 0; k < size.z; ++k) {
    const int z = up_z ? size.z - 1 - k : k, z_before = k ? (up_z ? z + 1 : z - 1) : z;
    const int layer = (z >> 2) * bricks.y, layer_before = (z_before >> 2) * bricks.y;
    for (int j = 0; j < size.y; ++j) {
      const int y = up_y ? size.y - 1 - j : j, y_before = j ? (up_y ? y + 1 : y - 1) : y;
      const int row = (layer + (y >> 2)) * bricks.x * 64 + (z & 3) * 16 + (y & 3) * 4;
      const int row_y = (layer + (y_before >> 2)) * bricks.x * 64 + (z & 3) * 16 + (y_before & 3) * 4;
      const int row_z = (layer_before + (y >> 2)) * bricks.x * 64 + (z_before & 3) * 16 + (y & 3) * 4;
      const int row_yz = (layer_before + (y_before >> 2)) * bricks.x * 64 + (z_before & 3) * 16 + (y_before & 3) * 4;
      int before = 254;
      for (int i = 0; i < size.x; ++i) {
        const int x = up_x ? size.x - 1 - i : i, at = (x >> 2) * 64 + (x & 3);
        int least = 254;
        if (j) least = min(least, (int)reaches[row_y + at]);
        if (k) least = min(least, (int)reaches[row_z + at]);
        if (j && k) least = min(least, (int)reaches[row_yz + at]);
        const int reach = abuffer_voxels[row + at] & ABUFFER_PARITY ? 0 : min(least, before) + 1;
        reaches[row + at] = (uchar)reach;
        before = min(least, reach);  // what the next one has of this voxel and those beside it
      }
    }
  }
}
