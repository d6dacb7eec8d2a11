// SPDX-License-Identifier: Apache-2.0
// Adds what the rays of sample_direct_light.cl found. Every point owns its sum: xyz, and w counts the samples.
#include "lucarium/medium.clh"
#include "lucarium/scene.clh"
#include "lucarium/services/direct_light/light_strategies.clh"

__kernel void add_direct_radiance(LUCARIUM_SCENE_PARAMETERS uint count, uint kinds,
                                  __global const float4* restrict shadow_light, __global const uint* restrict occluded,
                                  __global const Ray* restrict bsdf_rays, __global const float4* restrict bsdf_weights,
                                  __global const Hit* restrict hits, __global float4* restrict radiance) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  float3 light = occluded[i] ? (float3)(0.0f) : shadow_light[i].xyz;
  const float4 weight = bsdf_weights[i];
  if (weight.w > 0.0f) {
    const float3 direction = bsdf_rays[i].direction.xyz;
    const Hit hit = hits[i];
    if (hit.triangle != LUCARIUM_NO_HIT) {
      const Surface surface = make_surface(&scene, hit, direction, 0u);
      const float3 emission = emitted_radiance(&scene, &surface);
      const uint medium = medium_at(&scene, &surface, as_uint(shadow_light[i].w));
      if ((kinds >> LUCARIUM_LIGHT_TRIANGLE) & 1u && !is_black(emission))
        light += weight.xyz * medium_transmittance(&scene, medium, hit.distance) * emission *
                 mis_weight(weight.w, pdf_light_surface(&scene, &surface, hit.distance));
    } else if ((kinds >> LUCARIUM_LIGHT_ENVIRONMENT) & 1u && scene.scene_info->environment_light != LUCARIUM_NONE) {
      light += weight.xyz * environment_radiance(&scene, direction) *
               mis_weight(weight.w, pdf_light_environment(&scene, direction));
    }
  }
  radiance[i] += (float4)(light, 1.0f);
}
