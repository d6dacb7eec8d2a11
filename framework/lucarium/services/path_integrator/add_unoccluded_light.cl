// SPDX-License-Identifier: Apache-2.0
// Adds the light samples that nothing blocks to their paths.
#include "lucarium/services/path_integrator/path_state.clh"

// shadow_light: xyz contribution to the pixel [cd/m²]; w: bits of the counted scatterings it belongs to.
__kernel void add_unoccluded_light(PathBatch batch, __global const uint* restrict queue,
                                   __global const uint* restrict active, __global const Ray* restrict shadow_rays,
                                   __global const float4* restrict shadow_light, __global const uint* restrict occluded,
                                   __global float4* restrict path_radiance) {
  const uint i = get_global_id(0);
  if (i >= active[0] || shadow_rays[i].direction.w < 0.0f || occluded[i]) return;
  const float4 light = shadow_light[i];
  path_radiance[path_radiance_index(batch, queue[i], as_uint(light.w))] += (float4)(light.xyz, 0.0f);
}
