// SPDX-License-Identifier: Apache-2.0
// Closest and any hit over a uniform grid of triangle lists: the same triangle test as the hierarchy's, 8 at a time, so
// that hits are its hits to the bit. Walk: Amanatides and Woo 1987 (search/grid_ray.clh).
#define BVH_LEAF 8
#include "lucarium/services/ray_shares/ray_shares.clh"
#include "voxel_abuffer/compared/voxel_keys.clh"
#include "voxel_abuffer/search/grid_ray.clh"

#ifdef BVH_ALPHA
#define COMPARED_SCENE_PARAMETERS LUCARIUM_SCENE_PARAMETERS
#define COMPARED_SET_SCENE(context)          \
  LUCARIUM_SCENE_BIND(compared_alpha_scene); \
  (context).walk.triangles.scene = &compared_alpha_scene
#else
#define COMPARED_SCENE_PARAMETERS
#define COMPARED_SET_SCENE(context)
#endif

typedef struct ComparedGrid {
  AbufferContext walk;                  // its triangles are the blocks of the lists
  __global const ulong* bricks;         // a bit per occupied voxel
  __global const uint* first_of_brick;  // occupied voxels before the brick's
  __global const uint* block_start;     // first block of an occupied voxel
} ComparedGrid;

#define COMPARED_CONTEXT(context)                   \
  ComparedGrid context;                             \
  context.walk.triangles.nodes = 0;                 \
  context.walk.triangles.blocks = compared_blocks;  \
  context.walk.grid = compared_grid[0];             \
  context.bricks = compared_bricks;                 \
  context.first_of_brick = compared_first_of_brick; \
  context.block_start = compared_block_start;       \
  COMPARED_SET_SCENE(context)

// Triangles of a voxel may be hit behind it: the nearest hit is final only when the ray has come as far.
static bool compared_trace(const ComparedGrid* context, AbufferRay* r, Hit* best, const bool any) {
  for (;;) {
    const uint index = abuffer_voxel(context->walk.grid.bricks, as_uint4(r->voxel));
    const ulong bits = context->bricks[index >> 6];
    const int edge = bits == 0ul ? 4 : 1;
    int4 axes;
    const float leaves = abuffer_leave(&context->walk.grid, r, edge, &axes);
    if (bits >> (index & 63u) & 1ul) {
      const uint voxel = context->first_of_brick[index >> 6] + compared_rank(bits, index & 63u);
      const uint end = context->block_start[voxel + 1u];
      for (uint block = context->block_start[voxel]; block < end; ++block) {
        const uint word = block * LUCARIUM_BVH_BLOCK_WORDS(BVH_LEAF);
        if (!any)
          bvh_closest_in_leaf(&context->walk.triangles, word, &r->test, best);
        else if (bvh_any_in_leaf(&context->walk.triangles, word, &r->test, best->distance))
          return true;
      }
    }
    if (best->distance <= leaves || leaves >= r->end) return false;
    if (!abuffer_enter(&context->walk.grid, r, edge, axes, leaves)) return false;
  }
}

__kernel void compared_closest(COMPARED_SCENE_PARAMETERS __global const Ray* rays, __global Hit* hits,
                               RAY_SHARE_PARAMETERS, __global const AbufferGrid* compared_grid,
                               __global const ulong* compared_bricks, __global const uint* compared_first_of_brick,
                               __global const uint* compared_block_start, __global const float* compared_blocks) {
  COMPARED_CONTEXT(context);
  RAY_SHARE(share);
  for (uint i = share.first; i < share.end; ++i) {
    const Ray ray = rays[i];
    const Hit miss = {INFINITY, LUCARIUM_NO_HIT, 0.0f, 0.0f};
    Hit best = {fmin(ray.direction.w, MAXFLOAT), LUCARIUM_NO_HIT, 0.0f, 0.0f};
    AbufferRay r;
    if (abuffer_begin(&context.walk, ray, &r)) compared_trace(&context, &r, &best, false);
    hits[i] = best.triangle == LUCARIUM_NO_HIT ? miss : best;
  }
}

__kernel void compared_any(COMPARED_SCENE_PARAMETERS __global const Ray* rays, __global uint* occluded,
                           RAY_SHARE_PARAMETERS, __global const AbufferGrid* compared_grid,
                           __global const ulong* compared_bricks, __global const uint* compared_first_of_brick,
                           __global const uint* compared_block_start, __global const float* compared_blocks) {
  COMPARED_CONTEXT(context);
  RAY_SHARE(share);
  for (uint i = share.first; i < share.end; ++i) {
    const Ray ray = rays[i];
    Hit best = {fmin(ray.direction.w, MAXFLOAT), LUCARIUM_NO_HIT, 0.0f, 0.0f};
    AbufferRay r;
    occluded[i] = abuffer_begin(&context.walk, ray, &r) && compared_trace(&context, &r, &best, true);
  }
}
