// SPDX-License-Identifier: Apache-2.0
// light_choice=learned: sums of what each light's paths have brought, in the order of pixels and light paths, so that
// they do not depend on threads, and the shares that the next iteration chooses by (path_lights.clh).
#include "lucarium/lights.clh"
#include "lucarium/scene.clh"
#include "lucarium/sorted_keys.clh"

// Keys to sort by: the light whose path a connection was to, NONE where nothing arrives.
__kernel void key_connection_lights(__global const uint* restrict active, __global const Ray* restrict rays,
                                    __global const uint* restrict occluded,
                                    __global const uint* restrict connection_paths,
                                    __global const uint* restrict path_lights, uint count, __global uint* restrict keys,
                                    __global uint* restrict values, uint slice_base) {
  const uint i = slice_base + (uint)get_global_id(0);
  if (i >= count) return;
  const bool arrives = i < active[0] && ray_is_active(rays[i]) && !occluded[i];
  keys[i] = arrives ? path_lights[connection_paths[i]] : LUCARIUM_NONE;
  values[i] = i;
}

// The same of splats, of which a light path has `per_path`.
__kernel void key_splat_lights(__global const float4* restrict splats, __global const uint* restrict occluded,
                               __global const uint* restrict path_lights, uint per_path, uint count,
                               __global uint* restrict keys, __global uint* restrict values, uint slice_base) {
  const uint i = slice_base + (uint)get_global_id(0);
  if (i >= count) return;
  const bool arrives = as_uint(splats[i].w) != LUCARIUM_NONE && !occluded[i];
  keys[i] = arrives ? path_lights[i / per_path] : LUCARIUM_NONE;
  values[i] = i;
}

// Adds the luminance of all light of each key to the key's sum of the iteration.
__kernel void sum_by_light(__global const uint* restrict keys, __global const uint* restrict values,
                           __global const float4* restrict light, uint count, uint lights,
                           __global float* restrict sums, uint slice_base) {
  const uint l = slice_base + (uint)get_global_id(0);
  if (l >= lights) return;
  float sum = 0.0f;
  for (uint i = lower_key(keys, count, l); i < count && keys[i] == l; ++i) {
    const float brought = luminance(light[values[i]].xyz);
    if (brought > 0.0f && isfinite(brought)) sum += brought;
  }
  sums[l] += sum;
}

// What a whole iteration has brought; one that is cancelled teaches nothing.
__kernel void add_brought_light(__global const float* restrict brought, uint lights, __global float* restrict sums,
                                uint slice_base) {
  const uint l = slice_base + (uint)get_global_id(0);
  if (l < lights) sums[l] += brought[l];
}

// One work-item: shares from sums.
__kernel void share_lights(LUCARIUM_SCENE_PARAMETERS __global const float* restrict sums,
                           __global float* restrict shares) {
  LUCARIUM_SCENE_BIND(scene);
  const uint count = scene.scene_info->light_count;
  float total = 0.0f;
  for (uint l = 0u; l < count; ++l) total += sums[l];
  const bool some = total > 0.0f && isfinite(total);
  float before = 0.0f;
  for (uint l = 0u; l < count; ++l) {
    before += sums[l];
    shares[l] = !some ? 0.0f : l + 1u == count ? 1.0f : fmin(before / total, 1.0f);
  }
}
