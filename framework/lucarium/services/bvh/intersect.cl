// SPDX-License-Identifier: Apache-2.0
// Closest and any hit of a buffer of rays. A work-item has a share of the batch (CPU-like devices: local size 1) or one
// ray (GPU-like ones); the number of rays is read from a device counter.
#ifndef BVH_WIDTH
#define BVH_WIDTH 16
#define BVH_LEAF 8
#define BVH_STACK 128
#endif
// First and unconditionally: the framework resolves each include once, where it stands first.
#include "lucarium/services/bvh/ray_order.clh"
#include "lucarium/services/bvh/traverse.clh"
#if BVH_WIDTH >= 8
#include "lucarium/services/bvh/interleaved.clh"
#include "lucarium/services/bvh/packet.clh"
#include "lucarium/services/ray_shares/ray_shares.clh"
#else
#include "lucarium/services/bvh/single.clh"
#define bvh_trace_closest_mixed bvh_trace_closest_run
#define RAY_SHARE_PARAMETERS __global const uint *counter, uint counter_index, uint capacity, uint slice_base
#define RAY_SHARE(name)                                 \
  const uint ray = (uint)get_global_id(0) + slice_base; \
  const struct { uint first, end; } name = {ray, min(ray + 1u, min(counter[counter_index], capacity))}
#endif

#ifdef BVH_ALPHA
#define BVH_SCENE_PARAMETERS LUCARIUM_SCENE_PARAMETERS
#define BVH_CONTEXT(name)     \
  LUCARIUM_SCENE_BIND(scene); \
  const BvhContext name = {bvh_nodes, bvh_blocks, &scene}
#else
#define BVH_SCENE_PARAMETERS
#define BVH_CONTEXT(name) const BvhContext name = {bvh_nodes, bvh_blocks}
#endif

// row: RayBuffers::row.
__kernel void bvh_closest(BVH_SCENE_PARAMETERS __global const Ray* rays, __global Hit* hits, RAY_SHARE_PARAMETERS,
                          uint row, __global const float* bvh_nodes, __global const float* bvh_blocks) {
  BVH_CONTEXT(context);
  RAY_SHARE(share);
  const BvhOrder order = bvh_order(row, min(counter[counter_index], capacity));
  bvh_trace_closest_mixed(&context, rays, hits, order, share.first, share.end);
}

__kernel void bvh_any(BVH_SCENE_PARAMETERS __global const Ray* rays, __global uint* occluded, RAY_SHARE_PARAMETERS,
                      __global const float* bvh_nodes, __global const float* bvh_blocks) {
  BVH_CONTEXT(context);
  RAY_SHARE(share);
  bvh_trace_any_run(&context, rays, occluded, share.first, share.end);
}
