// SPDX-License-Identifier: Apache-2.0
// Chains of specular vertices: from texel sides towards a bundle's direction (for lobes too narrow for the transfer
// atlas of Hermes et al. 2010, section 5.4), and from what the camera sees (section 5.3). At every vertex the atlas
// gives the diffuse light, so a chain only follows specular lobes. Each target has one chain at a time.
#include "bundle_exchange/base/exchange_layout.clh"
#include "bundle_exchange/shared/contribution_layout.h"
#include "bundle_exchange/specular/pixel_lobes.clh"
#include "lucarium/atlas_surface.clh"
#include "lucarium/gbuffer.clh"
#include "lucarium/surface_atlas.clh"

// What chains find for their targets.
typedef struct Contributions {
  global float4* contribution;
  uint layout;  // HOP_GAIN_*
  // Of the atlas; not set where only light samples are added.
  AtlasInfo atlas_info;
  const global AtlasTriangle* atlas_triangles;
  const global uint* atlas_table;
  const global float4* diffuse;  // what texel sides send by their diffuse lobe, BUNDLE_REFLECTED channels each
  uint limit;                    // ChainSettings::limit
} Contributions;
#define CHAIN_CONSUMER Contributions
#include "lucarium/services/specular_chains/advance.clh"

void chain_light(Contributions* contributions, uint target, uint scatterings, float3 light) {
  size_t index = target;
  if (contributions->layout == CONTRIBUTION_CHANNELS) index = (size_t)target * BUNDLE_REFLECTED + scatterings - 1u;
  if (contributions->layout == CONTRIBUTION_LAYERS) index = 2u * (size_t)target + (scatterings > 1u);
  contributions->contribution[index].xyz += light;
}

// Diffuse light of a texel side; the backs of single-sided surfaces are none and end the chain.
bool chain_surface(Contributions* contributions, const Scene* scene, const SpecularChain* chain, const Surface* surface,
                   Hit hit) {
  const uint texel =
      atlas_texel(contributions->atlas_triangles, contributions->atlas_table, hit.triangle, hit.u, hit.v);
  const uint side = atlas_side(contributions->atlas_info, texel, surface->flags & LUCARIUM_SURFACE_FRONT);
  if (side == LUCARIUM_NONE) return false;
  for (uint k = 0u; k < BUNDLE_REFLECTED &&
                    (contributions->limit == LUCARIUM_NONE || k + 1u + chain->vertices <= contributions->limit);
       ++k)
    chain_light(contributions, chain->target, k + 1u + chain->vertices,
                chain->throughput.xyz * contributions->diffuse[(size_t)side * BUNDLE_REFLECTED + k].xyz);
  return true;
}

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
  float3 light = (float3)(0.0f);
  if (!settings.lit || !sample_chain_light(&scene, settings, &surface, &bsdf, &chain, &light, &shadow_ray))
    shadow_ray = inactive_ray();
  if (!extend_chain(&scene, settings, &surface, &bsdf, &chain, &ray)) ray = inactive_ray();
  chains[target] = chain;
  rays[i] = ray;
  shadow_rays[i] = shadow_ray;
  shadow_light[i] = (float4)(light, as_float(1u));
}

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

__kernel void advance_texel_chains(LUCARIUM_CHAIN_PARAMETERS AtlasInfo atlas_info,
                                   __global const AtlasTriangle* restrict atlas_triangles,
                                   __global const uint* restrict atlas_table, __global const float4* restrict diffuse,
                                   uint layout, __global float4* restrict contribution) {
  Contributions contributions = {contribution, layout,  atlas_info,    atlas_triangles,
                                 atlas_table,  diffuse, settings.limit};
  LUCARIUM_ADVANCE_CHAINS(&contributions);
}

__kernel void add_punctual(LUCARIUM_CHAIN_LIGHT_PARAMETERS uint layout, __global float4* restrict contribution) {
  Contributions contributions;
  contributions.contribution = contribution;
  contributions.layout = layout;
  LUCARIUM_ADD_CHAIN_LIGHT(&contributions);
}

// What listed texel sides send towards this direction: diffuse and found by their chains.
__kernel void apply_contributions(uint count, __global const uint* restrict list,
                                  __global const float4* restrict diffuse, __global const float4* restrict contribution,
                                  __global float4* restrict records) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const uint side = list[i];
  for (uint k = 0u; k < BUNDLE_REFLECTED; ++k) {
    global float4* send = records + (size_t)side * BUNDLE_RECORD + 2u * (BUNDLE_FIRST + k);
    (*send).xyz = diffuse[(size_t)side * BUNDLE_REFLECTED + k].xyz + contribution[(size_t)i * BUNDLE_REFLECTED + k].xyz;
  }
}
