// SPDX-License-Identifier: Apache-2.0
#include "lucarium/ray_ends.clh"

// Appends the active rays of a batch, with their ends and whether only whether anything blocks them counts (`shadow`);
// kept_count counts those beyond `room`, too.
__kernel void keep_ends(__global const Ray* restrict rays, __global const RayEnds* restrict ends,
                        __global const uint* restrict counter, const uint counter_index, const uint shadow,
                        const uint room, __global Ray* restrict kept_rays, __global uint4* restrict kept_ends,
                        __global uint* restrict kept_count) {
  const uint i = (uint)get_global_id(0);
  if (i >= counter[counter_index] || !(rays[i].direction.w >= 0.0f)) return;
  const uint place = atomic_inc(kept_count);
  if (place >= room) return;
  kept_rays[place] = rays[i];
  kept_ends[place] = (uint4)(ends[i].start, ends[i].end, shadow, 0u);
}

// Chains of a consumer that adds nothing: what surfaces reflect specularly of what camera rays meet.
typedef struct Nothing {
  uint unused;
} Nothing;
#define CHAIN_CONSUMER Nothing
#include "lucarium/gbuffer.clh"
#include "lucarium/services/specular_chains/advance.clh"

void chain_light(Nothing* consumer, uint target, uint scatterings, float3 light) {}
bool chain_surface(Nothing* consumer, const Scene* scene, const SpecularChain* chain, const Surface* surface, Hit hit) {
  return true;
}
__kernel void advance_kept_chains(LUCARIUM_CHAIN_PARAMETERS uint unused) {
  Nothing consumer = {unused};
  LUCARIUM_ADVANCE_CHAINS(&consumer);
}
__kernel void add_kept_light(LUCARIUM_CHAIN_LIGHT_PARAMETERS uint unused) {
  Nothing consumer = {unused};
  LUCARIUM_ADD_CHAIN_LIGHT(&consumer);
}

// A chain from every point of a G-buffer along its mirror direction, whatever the surface is made of.
__kernel void begin_kept_chains(LUCARIUM_SCENE_PARAMETERS __global const GBufferPoint* restrict points, uint count,
                                __global SpecularChain* restrict chains,
                                LUCARIUM_RAY_ENDS_PARAMETER(ends) __global Ray* restrict rays,
                                __global uint* restrict queue, __global uint* restrict active) {
  const uint i = get_global_id(0);
  if (i == 0u) active[0] = count;
  if (i >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  chains[i] = begin_chain(i, (float3)(1.0f), LUCARIUM_NONE);
  chains[i].vertices = 1u;
  rays[i] = inactive_ray();
  queue[i] = i;
  if (points[i].state != LUCARIUM_GBUFFER_SURFACE) return;
  const Surface surface = gbuffer_surface(&scene, points[i]);
  const float3 direction = 2.0f * dot(surface.n_g, surface.view) * surface.n_g - surface.view;
  rays[i] = make_ray(&surface, direction, make_ray_seed(i));
  LUCARIUM_STORE_RAY_ENDS(ends, i, ray_ends(&surface, direction));
}
