// SPDX-License-Identifier: Apache-2.0
// Closest and any hit over a grid of occupied voxels, a bit each: of those that a ray enters, the first one whose
// triangle counts is hit (compared_hit()). (Papaioannou, Menexi, Papadopoulos, "Real-Time Volume-Based Ambient
// Occlusion", 2010, is what Hu et al. 2014, section 5.2, compare with in figure 9.)
#include "voxel_abuffer/compared/compared_ray.clh"
#include "voxel_abuffer/compared/voxel_keys.clh"

typedef struct ComparedContext {
  AbufferContext walk;
  const Scene* scene;
  __global const ulong* bricks;      // a bit per voxel, all bricks of the grid
  __global const uint* brick_keys;   // of those that hold occupied voxels, ascending
  __global const uint* brick_first;  // occupied voxels of the bricks before
  __global const uint* leaves;       // triangle of an occupied voxel
  uint brick_count;
} ComparedContext;

#define COMPARED_PARAMETERS                                                            \
  __global const ulong *compared_bricks, __global const uint *compared_brick_keys,     \
      __global const uint *compared_brick_first, __global const uint *compared_leaves, \
      __global const uint *compared_brick_count
#define COMPARED_BIND(context)                \
  context.bricks = compared_bricks;           \
  context.brick_keys = compared_brick_keys;   \
  context.brick_first = compared_brick_first; \
  context.leaves = compared_leaves;           \
  context.brick_count = compared_brick_count[0]

// The triangle of an occupied voxel: only at hits, so that bits are all that rays read on their way.
static uint compared_triangle(const ComparedContext* context, uint brick, ulong bits, uint within) {
  uint low = 0u, high = context->brick_count - 1u;
  while (low < high) {
    const uint middle = (low + high) / 2u;
    if (context->brick_keys[middle] < brick)
      low = middle + 1u;
    else
      high = middle;
  }
  return context->leaves[context->brick_first[low] + compared_rank(bits, within)];
}

static bool compared_trace(const ComparedContext* context, AbufferRay* r, const Ray* ray, const Ray* moved, Hit* hit,
                           const bool any) {
  const AbufferGrid* grid = &context->walk.grid;
  for (;;) {
    const uint4 voxel = as_uint4(r->voxel);
    const uint brick = compared_brick(grid->bricks, voxel), within = compared_within(voxel);
    const ulong bits = context->bricks[brick];
    const int edge = bits == 0ul ? 4 : 1;
    int4 axes;
    const float leaves = abuffer_leave(grid, r, edge, &axes);
    if (bits >> within & 1ul) {
#ifndef BVH_ALPHA
      if (any) return true;
#endif
      const uint triangle = compared_triangle(context, brick, bits, within);
      if (compared_hit(context->scene, grid, ray, moved, triangle, r->distance, leaves, hit, any)) return true;
    }
    if (leaves >= r->end || !abuffer_enter(grid, r, edge, axes, leaves)) return false;
  }
}

#include "voxel_abuffer/compared/leaf_rays.clh"
