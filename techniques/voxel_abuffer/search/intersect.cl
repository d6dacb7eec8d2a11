// SPDX-License-Identifier: Apache-2.0
// Closest and any hit of a buffer of rays. A work-item has a share of the batch; the number of rays is read from
// a device counter. Compiled with ABUFFER_WITH_EXACT where there are triangles for exact search, and
// ABUFFER_WITH_PARITY (ABUFFER_STEPS: 0 for 2D-DDA, else 3 or 1, or ABUFFER_PLANES; ABUFFER_UNREFINED, ABUFFER_STORED)
// where there are those for parity, ABUFFER_REACHES where voxels know how far such rays may go
// (structure/mark_voxels.cl). ABUFFER_COUNT_WORK: with counts (search/work_counts.clh).
#include "lucarium/services/ray_shares/ray_shares.clh"
#include "voxel_abuffer/search/exact_flights.clh"
#include "voxel_abuffer/search/fragment_attributes.clh"  // not under a condition: files are included once
#ifndef ABUFFER_STEPS
#define ABUFFER_STEPS 0
#endif
#ifdef ABUFFER_PLANES
#include "voxel_abuffer/search/plane_columns.clh"
#else
#include "voxel_abuffer/search/parity_flights.clh"
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

#if defined(ABUFFER_WITH_EXACT) || (defined(ABUFFER_WITH_PARITY) && !defined(ABUFFER_PLANES))
#define ABUFFER_CELLS_PARAMETER , __global const ulong* abuffer_cells
#define ABUFFER_SET_CELLS(context) context.cells = abuffer_cells
#else
#define ABUFFER_CELLS_PARAMETER
#define ABUFFER_SET_CELLS(context)
#endif

#ifdef ABUFFER_WITH_EXACT
#define ABUFFER_EXACT_PARAMETERS                                                         \
  , __global const uint *abuffer_exact_start, __global const uint *abuffer_exact_depths, \
      __global const uint *abuffer_exact_fragments
#define ABUFFER_SET_EXACT(context)             \
  context.exact_start = abuffer_exact_start;   \
  context.exact_depths = abuffer_exact_depths; \
  context.exact_fragments = abuffer_exact_fragments
#else
#define ABUFFER_EXACT_PARAMETERS
#define ABUFFER_SET_EXACT(context)
#endif

#ifdef ABUFFER_STORED
#define ABUFFER_ATTRIBUTES_PARAMETER , __global const AbufferAttributes* abuffer_attributes
#define ABUFFER_SET_ATTRIBUTES(context) context.parity_attributes = abuffer_attributes
#else
#define ABUFFER_ATTRIBUTES_PARAMETER
#define ABUFFER_SET_ATTRIBUTES(context)
#endif

#ifdef ABUFFER_WITH_PARITY
#define ABUFFER_PARITY_PARAMETERS                                                                                      \
  , __global const RayEnds *ends, __global const uchar *abuffer_classes, float abuffer_offset,                         \
      uint abuffer_bisections, __global const uint *abuffer_parity_start, __global const float *abuffer_parity_depths, \
      __global const uint *abuffer_parity_fragments ABUFFER_ATTRIBUTES_PARAMETER
#define ABUFFER_SET_PARITY(context)                    \
  context.classes = abuffer_classes;                   \
  context.offset = abuffer_offset;                     \
  context.bisections = abuffer_bisections;             \
  context.parity_start = abuffer_parity_start;         \
  context.parity_depths = abuffer_parity_depths;       \
  context.parity_fragments = abuffer_parity_fragments; \
  abuffer_find_columns(&context);                      \
  ABUFFER_SET_ATTRIBUTES(context)
#else
#define ABUFFER_PARITY_PARAMETERS
#define ABUFFER_SET_PARITY(context)
#endif

#define ABUFFER_PARAMETERS                                                                                             \
  __global const AbufferGrid *abuffer_grid, __global const ulong *abuffer_bricks, __global const uint *abuffer_voxels, \
      __global const float *abuffer_triangles ABUFFER_CELLS_PARAMETER ABUFFER_EXACT_PARAMETERS                         \
          ABUFFER_PARITY_PARAMETERS ABUFFER_WORK_PARAMETER

#define ABUFFER_CONTEXT(context)                \
  AbufferContext context;                       \
  context.triangles.nodes = 0;                  \
  context.triangles.blocks = abuffer_triangles; \
  context.grid = abuffer_grid[0];               \
  context.bricks = abuffer_bricks;              \
  context.voxels = abuffer_voxels;              \
  ABUFFER_SET_CELLS(context);                   \
  ABUFFER_SET_EXACT(context);                   \
  ABUFFER_SET_PARITY(context);                  \
  ABUFFER_BEGIN_WORK(context);                  \
  ABUFFER_SET_SCENE(context)

// What the triangles for parity say of the rays first … end; those for exact search are a set of their own, and the
// nearer hit counts.
#if defined(ABUFFER_WITH_PARITY) && defined(ABUFFER_PLANES)
static void abuffer_trace_plane_chunk(const AbufferContext* context, const AbufferQueue queue,
                                      __global const RayEnds* ends, const bool any) {
  for (uint i = queue.next; i < queue.end; ++i) {
    const Ray ray = queue.rays[i];
    Hit best = {INFINITY, LUCARIUM_NO_HIT, 0.0f, 0.0f};
    AbufferPlaneRay r;
    const bool hit = abuffer_begin_planes(context, ray, ends[i], &r) && abuffer_trace_planes(context, &r, &best);
    if (!hit || !(any || best.distance <= ray.direction.w)) best.triangle = LUCARIUM_NO_HIT;
    abuffer_land(&queue, i, best, any);
  }
}
#define ABUFFER_TRACE_PARITY(hits, occluded, any)                              \
  {                                                                            \
    const AbufferQueue queue = {rays, hits, occluded, share.first, share.end}; \
    abuffer_trace_plane_chunk(&context, queue, ends, any);                     \
  }
#elif defined(ABUFFER_WITH_PARITY)
#define ABUFFER_TRACE_PARITY(hits, occluded, any)                                            \
  {                                                                                          \
    const AbufferParityQueue queue = {{rays, hits, occluded, share.first, share.end}, ends}; \
    abuffer_trace_parity_flights(&context, queue, any);                                      \
  }
#else
#define ABUFFER_TRACE_PARITY(hits, occluded, any)
#endif

#ifdef ABUFFER_WITH_EXACT
#define ABUFFER_TRACE_EXACT(hits, occluded, any)                               \
  {                                                                            \
    const AbufferQueue queue = {rays, hits, occluded, share.first, share.end}; \
    abuffer_trace_flights(&context, queue, any);                               \
  }
#else
#define ABUFFER_TRACE_EXACT(hits, occluded, any)
#endif

// A scene without triangles compiles neither: all rays miss.
#if !defined(ABUFFER_WITH_EXACT) && !defined(ABUFFER_WITH_PARITY)
#define ABUFFER_TRACE(hits, occluded, any)                                     \
  for (uint i = share.first; i < share.end; ++i) {                             \
    const Hit miss = {INFINITY, LUCARIUM_NO_HIT, 0.0f, 0.0f};                  \
    const AbufferQueue queue = {rays, hits, occluded, share.first, share.end}; \
    abuffer_land(&queue, i, miss, any);                                        \
  }
#else
#define ABUFFER_TRACE(hits, occluded, any) \
  ABUFFER_TRACE_PARITY(hits, occluded, any) ABUFFER_TRACE_EXACT(hits, occluded, any)
#endif

__kernel void abuffer_closest(ABUFFER_SCENE_PARAMETERS __global const Ray* rays, __global Hit* hits,
                              RAY_SHARE_PARAMETERS, ABUFFER_PARAMETERS) {
  ABUFFER_CONTEXT(context);
  RAY_SHARE(share);
  ABUFFER_TRACE(hits, 0, false)
  ABUFFER_END_WORK(context);
}

__kernel void abuffer_any(ABUFFER_SCENE_PARAMETERS __global const Ray* rays, __global uint* occluded,
                          RAY_SHARE_PARAMETERS, ABUFFER_PARAMETERS) {
  ABUFFER_CONTEXT(context);
  RAY_SHARE(share);
  ABUFFER_TRACE(0, occluded, true)
  ABUFFER_END_WORK(context);
}
