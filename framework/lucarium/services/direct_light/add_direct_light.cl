// SPDX-License-Identifier: Apache-2.0
// Adds what the rays of sample_direct_light.cl found. Every point owns its sum: xyz, and w counts the samples.
#include "lucarium/medium.clh"
#include "lucarium/scene.clh"
#include "lucarium/services/direct_light/light_strategies.clh"

// What a BSDF ray of this density has met, against light samples of the same emitter. medium: what it runs through.
LUCARIUM_JOIN float3 light_of_bsdf_ray(const Scene* scene, uint kinds, LitPoint point, float3 direction, Hit hit,
                                       float pdf, uint medium) {
  if (hit.triangle == LUCARIUM_NO_HIT) {
    if (!((kinds >> LUCARIUM_LIGHT_ENVIRONMENT) & 1u) || scene->scene_info->environment_light == LUCARIUM_NONE)
      return (float3)(0.0f);
    return environment_radiance(scene, direction) * mis_weight(pdf, pdf_light_environment(scene, point, direction));
  }
  // Most surfaces do not shine, and what a surface is takes long to find out.
  if (!((kinds >> LUCARIUM_LIGHT_TRIANGLE) & 1u) || !may_emit(scene, hit.triangle)) return (float3)(0.0f);
  const Surface surface = make_surface(scene, hit, direction, 0u);
  const float3 emission = emitted_radiance(scene, &surface);
  if (is_black(emission)) return (float3)(0.0f);
  return medium_transmittance(scene, medium_at(scene, &surface, medium), hit.distance) * emission *
         mis_weight(pdf, pdf_light_surface(scene, &surface, hit.distance, point.side));
}

__kernel void add_direct_radiance(LUCARIUM_SCENE_PARAMETERS uint count, uint kinds,
                                  __global const float4* restrict shadow_light, __global const uint* restrict occluded,
                                  __global const Ray* restrict bsdf_rays, __global const float4* restrict bsdf_weights,
                                  __global const uint* restrict sides, __global const Hit* restrict hits,
                                  __global float4* restrict radiance) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  float3 light = occluded[i] ? (float3)(0.0f) : shadow_light[i].xyz;
  const float4 weight = bsdf_weights[i];
  if (weight.w > 0.0f)
    light += weight.xyz * light_of_bsdf_ray(&scene, kinds, lit_point(bsdf_rays[i].origin.xyz, sides[i]),
                                            bsdf_rays[i].direction.xyz, hits[i], weight.w, as_uint(shadow_light[i].w));
  radiance[i] += (float4)(light, 1.0f);
}
