// SPDX-License-Identifier: Apache-2.0
// From the pairs of voxels and triangles, sorted by bricks, to what rays read: one brick per work-item.
#include "lucarium/shared/bvh_layout.h"
#include "lucarium/shared/scene_types.h"
#include "voxel_abuffer/compared/voxel_keys.clh"

#define COMPARED_LANES 8u  // triangles per block

// Into tables of all bricks of the grid.
__kernel void compared_place_bricks(__global const uint* compared_brick_keys,
                                    __global const ulong* compared_brick_masks, uint count,
                                    __global ulong* compared_bricks) {
  const uint b = get_global_id(0);
  if (b < count) compared_bricks[compared_brick_keys[b]] = compared_brick_masks[b];
}

__kernel void compared_place_first_voxels(__global const uint* compared_brick_keys,
                                          __global const uint* compared_brick_first, uint count,
                                          __global uint* compared_first_of_brick) {
  const uint b = get_global_id(0);
  if (b < count) compared_first_of_brick[compared_brick_keys[b]] = compared_brick_first[b];
}

#define COMPARED_RUN                          \
  const uint begin = compared_brick_start[b]; \
  const uint end = b + 1u < count ? compared_brick_start[b + 1u] : compared_total[0]

// The triangle of each occupied voxel: the one with the lowest index.
__kernel void compared_fill_leaves(__global const uint* compared_brick_start, __global const uint* compared_total,
                                   __global const uint* compared_order, __global const uchar* compared_within_brick,
                                   __global const uint* compared_triangles, __global const ulong* compared_brick_masks,
                                   __global const uint* compared_brick_first, uint count,
                                   __global uint* compared_leaves) {
  const uint b = get_global_id(0);
  if (b >= count) return;
  COMPARED_RUN;
  const ulong mask = compared_brick_masks[b];
  ulong seen = 0ul;
  for (uint i = begin; i < end; ++i) {
    const uint pair = compared_order[i], within = compared_within_brick[pair];
    if (seen >> within & 1ul) continue;
    seen |= 1ul << within;
    compared_leaves[compared_brick_first[b] + compared_rank(mask, within)] = compared_triangles[pair];
  }
}

// Blocks that the triangles of each occupied voxel take.
__kernel void compared_count_blocks(__global const uint* compared_brick_start, __global const uint* compared_total,
                                    __global const uint* compared_order, __global const uchar* compared_within_brick,
                                    __global const ulong* compared_brick_masks,
                                    __global const uint* compared_brick_first, uint count,
                                    __global uint* compared_block_counts) {
  const uint b = get_global_id(0);
  if (b >= count) return;
  COMPARED_RUN;
  uint counts[64];
  for (uint i = 0u; i < 64u; ++i) counts[i] = 0u;
  for (uint i = begin; i < end; ++i) ++counts[compared_within_brick[compared_order[i]]];
  uint place = compared_brick_first[b];
  for (uint i = 0u; i < 64u; ++i)
    if (counts[i]) compared_block_counts[place++] = (counts[i] + COMPARED_LANES - 1u) / COMPARED_LANES;
}

static void compared_store_corner(__global float* block, uint corner, uint lane, float4 p) {
  __global float* at = block + 3u * COMPARED_LANES * corner + lane;
  at[0] = p.x;
  at[COMPARED_LANES] = p.y;
  at[2u * COMPARED_LANES] = p.z;
}

// Blocks of triangles (lucarium/shared/bvh_layout.h), voxel by voxel.
__kernel void compared_fill_blocks(__global const Vertex* scene_vertices, __global const Triangle* scene_triangles,
                                   __global const uint* compared_brick_start, __global const uint* compared_total,
                                   __global const uint* compared_order, __global const uchar* compared_within_brick,
                                   __global const uint* compared_triangles, __global const ulong* compared_brick_masks,
                                   __global const uint* compared_brick_first, uint count,
                                   __global const uint* compared_block_start, __global float* compared_blocks) {
  const uint b = get_global_id(0);
  if (b >= count) return;
  COMPARED_RUN;
  const ulong mask = compared_brick_masks[b];
  const uint first = compared_brick_first[b], words = LUCARIUM_BVH_BLOCK_WORDS(COMPARED_LANES);
  uint filled[64];
  for (uint i = 0u; i < 64u; ++i) filled[i] = 0u;
  // Give each triangle the next lane of its voxel's blocks.
  for (uint i = begin; i < end; ++i) {
    const uint pair = compared_order[i], triangle = compared_triangles[pair];
    const uint voxel = compared_rank(mask, compared_within_brick[pair]), slot = filled[voxel]++;
    __global float* block = compared_blocks + (compared_block_start[first + voxel] + slot / COMPARED_LANES) * words;
    const Triangle t = scene_triangles[triangle];
    const uint lane = slot % COMPARED_LANES;
    compared_store_corner(block, 0u, lane, scene_vertices[t.v0].position);
    compared_store_corner(block, 1u, lane, scene_vertices[t.v1].position);
    compared_store_corner(block, 2u, lane, scene_vertices[t.v2].position);
    ((__global uint*)block)[LUCARIUM_BVH_BLOCK_TRIANGLES(COMPARED_LANES) + lane] = triangle;
  }
  // Empty lanes repeat one point, which nothing hits.
  for (uint voxel = 0u; voxel < (uint)popcount(mask); ++voxel) {
    __global float* block = compared_blocks + (compared_block_start[first + voxel + 1u] - 1u) * words;
    const float4 point = (float4)(block[0], block[COMPARED_LANES], block[2u * COMPARED_LANES], 0.0f);
    for (uint lane = (filled[voxel] - 1u) % COMPARED_LANES + 1u; lane < COMPARED_LANES; ++lane) {
      for (uint corner = 0u; corner < 3u; ++corner) compared_store_corner(block, corner, lane, point);
      ((__global uint*)block)[LUCARIUM_BVH_BLOCK_TRIANGLES(COMPARED_LANES) + lane] = 0xffffffffu;
    }
  }
}
