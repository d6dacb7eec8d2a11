// SPDX-License-Identifier: Apache-2.0
// The smallest consumer of specular chains: what arrives at each target, by number of scatterings. Every surface sends
// radiance 1 by lobes that chains do not follow, where `glowing`.
#define SCATTERINGS 8u

typedef struct Contributions {
  __global float4* gain;  // [target][min(scatterings, SCATTERINGS - 1)]
  uint glowing;
} Contributions;
#define CHAIN_CONSUMER Contributions
#include "lucarium/services/specular_chains/advance.clh"

void chain_light(Contributions* found, uint target, uint scatterings, float3 light) {
  found->gain[target * SCATTERINGS + min(scatterings, SCATTERINGS - 1u)].xyz += light;
}
bool chain_surface(Contributions* found, const Scene* scene, const SpecularChain* chain, const Surface* surface,
                   Hit hit) {
  if (found->glowing) chain_light(found, chain->target, chain->vertices, chain->throughput.xyz);
  return true;
}

__kernel void advance_test_chains(LUCARIUM_CHAIN_PARAMETERS uint glowing, __global float4* restrict gain) {
  Contributions found = {gain, glowing};
  LUCARIUM_ADVANCE_CHAINS(&found);
}
__kernel void add_test_light(LUCARIUM_CHAIN_LIGHT_PARAMETERS uint glowing, __global float4* restrict gain) {
  Contributions found = {gain, glowing};
  LUCARIUM_ADD_CHAIN_LIGHT(&found);
}

// Every chain starts at `origin` along `direction`, as if it had one vertex there.
__kernel void begin_test_chains(uint count, float4 origin, float4 direction, __global SpecularChain* restrict chains,
                                __global Ray* restrict rays, __global uint* restrict queue,
                                __global uint* restrict active, __global float4* restrict gain) {
  const uint i = get_global_id(0);
  if (i == 0u) active[0] = count;
  if (i >= count) return;
  for (uint k = 0u; k < SCATTERINGS; ++k) gain[i * SCATTERINGS + k] = (float4)(0.0f);
  chains[i] = begin_chain(i, (float3)(1.0f), LUCARIUM_NONE);
  chains[i].vertices = 1u;
  rays[i].origin = (float4)(origin.xyz, as_float(make_ray_seed(i)));
  rays[i].direction = (float4)(direction.xyz, INFINITY);
  queue[i] = i;
}

// What a point light of `intensity` at `light` gives where a ray first meets triangle 0 at barycentrics u, v.
__kernel void reflected_light(LUCARIUM_SCENE_PARAMETERS float u, float v, float4 direction, float4 light,
                              float4 intensity, __global float4* restrict result) {
  LUCARIUM_SCENE_BIND(scene);
  Hit hit;
  hit.distance = 1.0f;
  hit.triangle = 0u;
  hit.u = u;
  hit.v = v;
  const Surface surface = make_surface(&scene, hit, direction.xyz, 0u);
  const Bsdf full = make_bsdf(&scene, &surface, 0u), bsdf = specular_part(full);
  const float3 to_light = light.xyz - surface.position;
  result[0] = (float4)(eval_bsdf(&bsdf, normalize(to_light)) * intensity.xyz / dot(to_light, to_light), 0.0f);
}
