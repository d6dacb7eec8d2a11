// SPDX-License-Identifier: Apache-2.0
// Chains from texel sides towards a bundle's direction, for lobes too narrow for the transfer atlas of Hermes et al.
// 2010, section 5.4: which texel sides get one, and its first ray.
#include "bundle_exchange/base/exchange_layout.clh"
#include "lucarium/atlas_surface.clh"
#include "lucarium/services/specular_chains/chain.clh"

// Which entries of the list of specular texel sides get a chain: each with its own probability. Clears
// all contributions.
__kernel void choose_sides(uint count, __global const float* restrict probabilities, ChainSettings settings,
                           __global uint* restrict chosen, __global float4* restrict contribution) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  for (uint k = 0u; k < BUNDLE_REFLECTED; ++k) contribution[(size_t)i * BUNDLE_REFLECTED + k] = (float4)(0.0f);
  chosen[i] = uint_to_unit(hash_uint3(settings.seed, i, 0x73686172u)) < probabilities[i];
}

// Work-item i: entry queue[i] of the list, seen from the one of the directions `omega` and -omega that is on its side.
__kernel void begin_side_chains(LUCARIUM_SCENE_PARAMETERS AtlasInfo atlas_info,
                                __global const AtlasTexel* restrict atlas_texels, __global const uint* restrict list,
                                __global const float* restrict probabilities, float4 omega, ChainSettings settings,
                                __global SpecularChain* restrict chains, __global Ray* restrict rays,
                                __global const uint* restrict queue, __global const uint* restrict active,
                                __global Ray* restrict shadow_rays, __global float4* restrict shadow_light) {
  const uint i = get_global_id(0);
  if (i >= active[0]) return;
  LUCARIUM_SCENE_BIND(scene);
  const uint target = queue[i], side = list[target];
  const AtlasTexel texel = atlas_texels[side];
  Surface surface = atlas_surface(&scene, atlas_info, side, texel.triangle, texel.b1, texel.b2);
  // The viewer stands where that side can be seen from.
  surface.view = dot(surface.n_g, omega.xyz) > 0.0f ? omega.xyz : -omega.xyz;
  const Bsdf full = make_bsdf(&scene, &surface, 0u), bsdf = specular_part(full);
  // Begin the chain with the diffuse lobe left out: what the texel side sends by it is known.
  SpecularChain chain =
      begin_chain(target, (float3)(1.0f / probabilities[target]), medium_at(&scene, &surface, LUCARIUM_NONE));
  Ray ray = inactive_ray(), shadow_ray = ray;
  RayEnds ends;
  float3 light = (float3)(0.0f);
  if (!settings.lit || !sample_chain_light(&scene, settings, &surface, &bsdf, &chain, &light, &shadow_ray, &ends))
    shadow_ray = inactive_ray();
  if (!extend_chain(&scene, settings, &surface, &bsdf, &chain, &ray)) ray = inactive_ray();
  chains[target] = chain;
  rays[i] = ray;
  shadow_rays[i] = shadow_ray;
  shadow_light[i] = (float4)(light, as_float(1u));
}
