// SPDX-License-Identifier: Apache-2.0
// Closest and any hit of a buffer of rays. A work-item owns ABUFFER_CHUNK consecutive rays; the number of rays is read
// from a device counter.
#include "voxel_abuffer/search/exact_columns.clh"

#ifndef ABUFFER_CHUNK
#define ABUFFER_CHUNK 1024u
#endif

#ifdef BVH_ALPHA
#define ABUFFER_SCENE_PARAMETERS LUCARIUM_SCENE_PARAMETERS
#define ABUFFER_SET_SCENE(context)    \
  LUCARIUM_SCENE_BIND(abuffer_scene); \
  (context).triangles.scene = &abuffer_scene
#else
#define ABUFFER_SCENE_PARAMETERS
#define ABUFFER_SET_SCENE(context)
#endif

#define ABUFFER_PARAMETERS                                                                                             \
  __global const AbufferGrid *abuffer_grid, __global const ulong *abuffer_bricks, __global const uint *abuffer_voxels, \
      __global const ulong *abuffer_cells, __global const float *abuffer_triangles,                                    \
      __global const uint *abuffer_exact_start, __global const uint *abuffer_exact_depths,                             \
      __global const uint *abuffer_exact_fragments

#define ABUFFER_CONTEXT(context)                     \
  AbufferContext context;                            \
  context.triangles.nodes = 0;                       \
  context.triangles.blocks = abuffer_triangles;      \
  context.grid = abuffer_grid[0];                    \
  context.bricks = abuffer_bricks;                   \
  context.voxels = abuffer_voxels;                   \
  context.cells = abuffer_cells;                     \
  context.exact_start = abuffer_exact_start;         \
  context.exact_depths = abuffer_exact_depths;       \
  context.exact_fragments = abuffer_exact_fragments; \
  ABUFFER_SET_SCENE(context)

// Walks through the grid. Hits may lie behind the voxel in which they are found: the nearest one is final only when the
// ray has come as far.
static bool abuffer_trace(const AbufferContext* context, AbufferRay* r, Hit* best, const bool any) {
  uint last = LUCARIUM_NO_HIT;
  for (;;) {
    const uint index = abuffer_voxel(context->grid.bricks, as_uint4(r->voxel));
    const ulong bits = context->bricks[index >> 6];
    int4 axes;
    const float leaves = abuffer_exit(context, r, bits == 0ul, &axes);
    if (bits >> (index & 63u) & 1ul) {
      if (abuffer_search_voxel(context, r, context->voxels[index], leaves, &last, best, any)) return true;
    }
    if (best->distance <= leaves || leaves >= r->end) return false;
    if (!abuffer_step(context, r, bits == 0ul, axes, leaves)) return false;
  }
}

__kernel void abuffer_closest(ABUFFER_SCENE_PARAMETERS __global const Ray* rays, __global Hit* hits,
                              __global const uint* counter, uint counter_index, uint capacity, uint slice_base,
                              ABUFFER_PARAMETERS) {
  ABUFFER_CONTEXT(context);
  const uint count = min(counter[counter_index], capacity);
  const uint first = ((uint)get_global_id(0) + slice_base) * ABUFFER_CHUNK;
  for (uint i = first; i < min(first + ABUFFER_CHUNK, count); ++i) {
    const Ray ray = rays[i];
    const Hit miss = {INFINITY, LUCARIUM_NO_HIT, 0.0f, 0.0f};
    Hit best = {fmin(ray.direction.w, MAXFLOAT), LUCARIUM_NO_HIT, 0.0f, 0.0f};
    AbufferRay r;
    if (abuffer_begin(&context, ray, &r)) abuffer_trace(&context, &r, &best, false);
    hits[i] = best.triangle == LUCARIUM_NO_HIT ? miss : best;
  }
}

__kernel void abuffer_any(ABUFFER_SCENE_PARAMETERS __global const Ray* rays, __global uint* occluded,
                          __global const uint* counter, uint counter_index, uint capacity, uint slice_base,
                          ABUFFER_PARAMETERS) {
  ABUFFER_CONTEXT(context);
  const uint count = min(counter[counter_index], capacity);
  const uint first = ((uint)get_global_id(0) + slice_base) * ABUFFER_CHUNK;
  for (uint i = first; i < min(first + ABUFFER_CHUNK, count); ++i) {
    const Ray ray = rays[i];
    Hit best = {fmin(ray.direction.w, MAXFLOAT), LUCARIUM_NO_HIT, 0.0f, 0.0f};
    AbufferRay r;
    occluded[i] = abuffer_begin(&context, ray, &r) && abuffer_trace(&context, &r, &best, true);
  }
}
