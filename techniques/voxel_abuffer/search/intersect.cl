// SPDX-License-Identifier: Apache-2.0
// Closest and any hit of a buffer of rays. A work-item owns ABUFFER_CHUNK consecutive rays; the number of rays is read
// from a device counter. Compiled with ABUFFER_WITH_EXACT where there are triangles for exact search, and
// ABUFFER_WITH_PARITY (ABUFFER_STEPS: 0 for 2D-DDA, else 3 or 1; ABUFFER_UNREFINED) where there are those for parity.
#include "voxel_abuffer/search/exact_columns.clh"
#ifndef ABUFFER_STEPS
#define ABUFFER_STEPS 0
#endif
#include "voxel_abuffer/search/parity_columns.clh"

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

#ifdef ABUFFER_WITH_EXACT
#define ABUFFER_EXACT_PARAMETERS                                                   \
  , __global const ulong *abuffer_cells, __global const uint *abuffer_exact_start, \
      __global const uint *abuffer_exact_depths, __global const uint *abuffer_exact_fragments
#define ABUFFER_SET_EXACT(context)             \
  context.cells = abuffer_cells;               \
  context.exact_start = abuffer_exact_start;   \
  context.exact_depths = abuffer_exact_depths; \
  context.exact_fragments = abuffer_exact_fragments
#else
#define ABUFFER_EXACT_PARAMETERS
#define ABUFFER_SET_EXACT(context)
#endif

#ifdef ABUFFER_WITH_PARITY
#define ABUFFER_PARITY_PARAMETERS                                                                                      \
  , __global const RayEnds *ends, __global const uchar *abuffer_classes, float abuffer_offset,                         \
      uint abuffer_bisections, __global const uint *abuffer_parity_start, __global const float *abuffer_parity_depths, \
      __global const uint *abuffer_parity_fragments
#define ABUFFER_SET_PARITY(context)              \
  context.classes = abuffer_classes;             \
  context.offset = abuffer_offset;               \
  context.bisections = abuffer_bisections;       \
  context.parity_start = abuffer_parity_start;   \
  context.parity_depths = abuffer_parity_depths; \
  context.parity_fragments = abuffer_parity_fragments
#else
#define ABUFFER_PARITY_PARAMETERS
#define ABUFFER_SET_PARITY(context)
#endif

#define ABUFFER_PARAMETERS                                                                                             \
  __global const AbufferGrid *abuffer_grid, __global const ulong *abuffer_bricks, __global const uint *abuffer_voxels, \
      __global const float *abuffer_triangles ABUFFER_EXACT_PARAMETERS ABUFFER_PARITY_PARAMETERS

#define ABUFFER_CONTEXT(context)                \
  AbufferContext context;                       \
  context.triangles.nodes = 0;                  \
  context.triangles.blocks = abuffer_triangles; \
  context.grid = abuffer_grid[0];               \
  context.bricks = abuffer_bricks;              \
  context.voxels = abuffer_voxels;              \
  ABUFFER_SET_EXACT(context);                   \
  ABUFFER_SET_PARITY(context);                  \
  ABUFFER_SET_SCENE(context)

// Walks through the grid. Hits may lie behind the voxel in which they are found: the nearest one is final only when the
// ray has come as far.
static bool abuffer_trace_exact(const AbufferContext* context, AbufferRay* r, Hit* best, const bool any) {
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

// Whether an any-hit ray is stopped; of others the nearest hit. Triangles for parity and those for exact search are two
// sets, and the nearer of their hits counts.
static bool abuffer_trace(const AbufferContext* context, const Ray ray, const RayEnds ends, Hit* best, const bool any) {
#ifdef ABUFFER_WITH_PARITY
  AbufferParityRay p;
  if (abuffer_begin_parity(context, ray, ends, &p)) {
    Hit hit = *best;
    if (abuffer_trace_parity(context, &p, &hit, any)) {
      if (any) return true;
      if (hit.distance <= best->distance) *best = hit;
    }
  }
#endif
#ifdef ABUFFER_WITH_EXACT
  AbufferRay r;
  if (abuffer_begin(context, ray, &r)) return abuffer_trace_exact(context, &r, best, any);
#endif
  return false;
}

#ifdef ABUFFER_WITH_PARITY
#define ABUFFER_ENDS(i) ends[i]
#else
#define ABUFFER_ENDS(i) none
#endif

__kernel void abuffer_closest(ABUFFER_SCENE_PARAMETERS __global const Ray* rays, __global Hit* hits,
                              __global const uint* counter, uint counter_index, uint capacity, uint slice_base,
                              ABUFFER_PARAMETERS) {
  ABUFFER_CONTEXT(context);
  const RayEnds none = {LUCARIUM_NONE, LUCARIUM_NONE};
  const uint count = min(counter[counter_index], capacity);
  const uint first = ((uint)get_global_id(0) + slice_base) * ABUFFER_CHUNK;
  for (uint i = first; i < min(first + ABUFFER_CHUNK, count); ++i) {
    const Ray ray = rays[i];
    const Hit miss = {INFINITY, LUCARIUM_NO_HIT, 0.0f, 0.0f};
    Hit best = {fmin(ray.direction.w, MAXFLOAT), LUCARIUM_NO_HIT, 0.0f, 0.0f};
    abuffer_trace(&context, ray, ABUFFER_ENDS(i), &best, false);
    hits[i] = best.triangle == LUCARIUM_NO_HIT ? miss : best;
  }
}

__kernel void abuffer_any(ABUFFER_SCENE_PARAMETERS __global const Ray* rays, __global uint* occluded,
                          __global const uint* counter, uint counter_index, uint capacity, uint slice_base,
                          ABUFFER_PARAMETERS) {
  ABUFFER_CONTEXT(context);
  const RayEnds none = {LUCARIUM_NONE, LUCARIUM_NONE};
  const uint count = min(counter[counter_index], capacity);
  const uint first = ((uint)get_global_id(0) + slice_base) * ABUFFER_CHUNK;
  for (uint i = first; i < min(first + ABUFFER_CHUNK, count); ++i) {
    const Ray ray = rays[i];
    Hit best = {fmin(ray.direction.w, MAXFLOAT), LUCARIUM_NO_HIT, 0.0f, 0.0f};
    occluded[i] = abuffer_trace(&context, ray, ABUFFER_ENDS(i), &best, true);
  }
}
