// SPDX-License-Identifier: Apache-2.0
// Chains from what the camera sees (Hermes et al. 2010, section 5.3, by rays).
#include "bundle_exchange/specular/pixel_lobes.clh"
#include "lucarium/gbuffer.clh"
#include "lucarium/services/specular_chains/chain.clh"

// Work-item i: pixel i. `whole`: the diffuse lobe is sampled too, instead of being looked up at the pixel. max_alpha:
// bundles gather for reflection lobes from this width on, so that no chain begins there.
__kernel void begin_pixel_chains(LUCARIUM_SCENE_PARAMETERS __global const GBufferPoint* restrict points, uint count,
                                 uint whole, float max_alpha, ChainSettings settings,
                                 __global float4* restrict contribution, __global SpecularChain* restrict chains,
                                 __global Ray* restrict rays, __global uint* restrict queue,
                                 __global uint* restrict active) {
  const uint i = get_global_id(0);
  if (i == 0u) active[0] = count;
  if (i >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  contribution[2u * i] = contribution[2u * i + 1u] = (float4)(0.0f);
  queue[i] = i;
  Ray ray = inactive_ray();
  const GBufferPoint point = points[i];
  if (point.state == LUCARIUM_GBUFFER_SURFACE) {
    const Surface surface = gbuffer_surface(&scene, point);
    const Bsdf full = make_bsdf(&scene, &surface, 0u);
    // Keep the lobes that are neither looked up in the atlas nor gathered by bundles.
    Bsdf bsdf = full;
    if (!whole) bsdf = lobe_is_wide(&full, max_alpha) ? black_bsdf(&surface) : specular_part(full);
    SpecularChain chain = begin_chain(i, point.throughput.xyz, gbuffer_medium(point));
    // Ideal lobes belong to the G-buffer's path.
    const uint2 before =
        (uint2)(bsdf.flags & LUCARIUM_BSDF_DELTA_REFLECTION, bsdf.flags & LUCARIUM_BSDF_DELTA_TRANSMISSION);
    if (before.x) bsdf.f0 = (float3)(0.0f), bsdf.f90 = 0.0f;
    if (before.y) bsdf.transmission = (float3)(0.0f);
    if (before.x | before.y) choose_lobe_probabilities(&bsdf);
    if (!extend_chain(&scene, settings, &surface, &bsdf, &chain, &ray)) ray = inactive_ray();
    chains[i] = chain;
  }
  rays[i] = ray;
}
