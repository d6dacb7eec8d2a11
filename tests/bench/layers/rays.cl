// SPDX-License-Identifier: Apache-2.0
// The same rays one by one: through every pixel's centre, closest hit after closest hit.
#include "lucarium/shared/layered_raster.h"
#include "lucarium/shared/ray.h"

static float3 cross_of(float4 a, float4 b) { return cross(a.xyz, b.xyz); }

__kernel void first_rays(__global const LayeredView* views, uint view_index, float far_depth, __global Ray* rays,
                         __global uint* counter) {
  const uint i = get_global_id(0);
  const LayeredView view = views[view_index];
  if (i == 0u) counter[0] = view.width * view.height;
  if (i >= view.width * view.height) return;
  // Tiles of 4 x 4 pixels, so that runs of 16 rays are coherent.
  const uint tiles = view.width / 4u, tile = i / 16u, within = i % 16u;
  const float x = (float)(tile % tiles * 4u + within % 4u) + 0.5f, y = (float)(tile / tiles * 4u + within / 4u) + 0.5f;
  const float3 axis = view.row_w.xyz;
  const float3 right = view.row_x.xyz / dot(view.row_x.xyz, view.row_x.xyz);
  const float3 down = view.row_y.xyz / dot(view.row_y.xyz, view.row_y.xyz);
  const float3 origin = right * (x - view.row_x.w) + down * (y - view.row_y.w) + axis * (view.depth_min - view.row_w.w);
  rays[i].origin = (float4)(origin, 0.0f);
  rays[i].direction = (float4)(axis, far_depth);
}

// Rays that hit go on behind the hit; `next` and `next_counter` take them in order of arrival.
__kernel void next_rays(__global const Ray* rays, __global const Hit* hits, __global const uint* counter,
                        __global Ray* next, volatile __global uint* next_counter, __global uint* found) {
  const uint first = get_global_id(0) * 1024u, end = min(first + 1024u, counter[0]);
  if (first >= end) return;
  uint count = 0u;
  for (uint i = first; i < end; ++i) count += hits[i].triangle != LUCARIUM_NO_HIT;
  uint place = atomic_add(next_counter, count);
  atomic_add(found, count);
  for (uint i = first; i < end; ++i) {
    if (hits[i].triangle == LUCARIUM_NO_HIT) continue;
    Ray ray = rays[i];
    const float step = hits[i].distance + 1e-4f;
    ray.origin.xyz += ray.direction.xyz * step;
    ray.direction.w -= step;
    next[place++] = ray;
  }
}
