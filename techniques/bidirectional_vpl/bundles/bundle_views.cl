// SPDX-License-Identifier: Apache-2.0
// The views in which an iteration's bundles are rasterized: orthographic, along each bundle's direction, turned about
// it and shifted at random, just large enough for the points that look along it, or for the scene where they are kept.
#include "bidirectional_vpl/base/eye_directions.clh"
#include "bidirectional_vpl/bundles/bundle_set.clh"
#include "lucarium/scene.clh"
#include "lucarium/shared/layered_raster.h"
#include "lucarium/shared/ray.h"
#include "lucarium/sorted_keys.clh"

#define BUNDLE_VIEW_STREAM 0x76696577u
#define BUNDLE_MARGIN 3.0f  // pixels: the shift, and a border on both sides

// Of each run of `chunk` rays: keys to sort by, and the box of the points that look along bundles. The key is the
// bundle of ray i; settings.bundles for those that are traced, one more beyond the last ray. left[i]: the triangle that
// it leaves, apart from its state, of which look-ups need nothing else. bounds[2c]: the box's lower corner, bounds[2c +
// 1] the upper.
__kernel void key_bundle_rays(const BidirectionalSettings settings, __global const uint* restrict queue,
                              __global const uint* restrict active, __global const EyePathState* restrict states,
                              __global const Ray* restrict rays, uint chunk, __global uint* restrict keys,
                              __global uint* restrict values, __global uint* restrict left,
                              __global float4* restrict bounds) {
  const uint c = (uint)get_global_id(0), first = c * chunk;
  if (first >= settings.pixels) return;
  const uint end = min(first + chunk, settings.pixels), there = clamp(active[0], first, end);
  float4 low = (float4)(INFINITY), high = (float4)(-INFINITY);
  for (uint i = first; i < there; ++i) {
    const __global EyePathState* state = states + queue[i];
    const uint bundle = state->bundle;
    left[i] = state->left;
    keys[i] = min(bundle, settings.bundles);
    values[i] = i;
    if (bundle == LUCARIUM_NONE) continue;
    low = fmin(low, rays[i].origin);
    high = fmax(high, rays[i].origin);
  }
  for (uint i = there; i < end; ++i) {
    keys[i] = settings.bundles + 1u;
    values[i] = i;
  }
  bounds[2u * c] = low;
  bounds[2u * c + 1u] = high;
}

// Projection of a box onto a unit axis: where it begins, relative to its centre, is -half_extent().
float half_extent(float3 axis, float3 half_size) { return dot(fabs(axis), half_size); }

// Work-item k: the view of bundle k. The first edge of camera paths needs the box of its points, deeper ones the
// scene's. A bundle runs both ways through the whole scene, whatever it shows of it sideways.
__kernel void make_bundle_views(LUCARIUM_SCENE_PARAMETERS const BidirectionalSettings settings, uint seed,
                                uint sample_index, uint depth, uint side, __global const float4* restrict bounds,
                                uint chunks, __global LayeredView* restrict views) {
  const uint k = (uint)get_global_id(0);
  if (k >= settings.bundles) return;
  LUCARIUM_SCENE_BIND(scene);
  const float3 scene_low = scene.scene_info->bounds_min.xyz, scene_high = scene.scene_info->bounds_max.xyz;
  const float radius = fmax(scene.scene_info->bounds_max.w, 1e-20f);
  float3 low = (float3)(INFINITY), high = (float3)(-INFINITY);
  for (uint c = 0u; c < (depth == 0u ? chunks : 0u); ++c) {
    low = fmin(low, bounds[2u * c].xyz);
    high = fmax(high, bounds[2u * c + 1u].xyz);
  }
  if (!all(low <= high)) {
    low = scene_low;
    high = scene_high;
  }

  // Draw the turn and the shift.
  const Sampler set = bundle_set(settings, seed, sample_index, depth, k);
  const float3 along = bundle_direction(&scene, &set);
  const float4 u = random_float4(set.seed ^ BUNDLE_VIEW_STREAM, set.index, depth);
  const Basis basis = make_basis(along);
  float cosine;
  const float sine = sincos_turns(u.x, &cosine);
  const float3 x = cosine * basis.t + sine * basis.b, y = cross(along, x);

  // Place the box into the image.
  const float3 half_size = 0.5f * (high - low), center = low + half_size;
  const float reach_x = half_extent(x, half_size), reach_y = half_extent(y, half_size);
  const float pixel = fmax(2.0f * fmax(reach_x, reach_y) / ((float)side - BUNDLE_MARGIN), 1e-6f * radius);
  const float3 middle = 0.5f * (scene_low + scene_high);
  LayeredView view;
  view.row_x = (float4)(x / pixel, 1.0f + u.y + (reach_x - dot(x, center)) / pixel);
  view.row_y = (float4)(y / pixel, 1.0f + u.z + (reach_y - dot(y, center)) / pixel);
  view.row_w = (float4)(along, -dot(along, middle));
  view.depth_min = -1.001f * radius;
  view.depth_scale = 1.0f / (2.002f * radius);
  view.width = view.height = side;
  view.seed = hash_uint3(set.seed, set.index, depth) | 1u;
  view.classes = view.pad0 = view.pad1 = 0u;
  views[k] = view;
}

// starts[k]: the first of the sorted rays of bundle k; of the traced ones where k is settings.bundles.
__kernel void find_bundle_starts(const BidirectionalSettings settings, __global const uint* restrict keys,
                                 __global uint* restrict starts) {
  const uint k = (uint)get_global_id(0);
  if (k <= settings.bundles) starts[k] = lower_key(keys, settings.pixels, k);
}
