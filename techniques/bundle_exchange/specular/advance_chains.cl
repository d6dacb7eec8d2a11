// SPDX-License-Identifier: Apache-2.0
// Chains of specular vertices, from texel sides (begin_side_chains.cl) and from what the camera sees
// (begin_pixel_chains.cl). At every vertex the atlas gives the diffuse light, so a chain only follows specular lobes.
// Each target has one chain at a time.
#include "bundle_exchange/base/exchange_layout.clh"
#include "bundle_exchange/shared/contribution_layout.h"
#include "lucarium/atlas_surface.clh"
#include "lucarium/services/texel_sides/side_halves.clh"

// What chains find for their targets.
typedef struct Contributions {
  __global float4* contribution;
  uint layout;  // CONTRIBUTION_*
  // Of the atlas; not set where only light samples are added.
  AtlasInfo atlas_info;
  const __global AtlasTriangle* atlas_triangles;
  const __global uint* atlas_table;
  uint half_count;
  const __global uint* covered;
  const __global float4* diffuse;  // what texel sides send by their diffuse lobe, BUNDLE_REFLECTED channels each
  uint limit;                      // ChainSettings::limit
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
  const size_t sender = side + half_at(contributions->atlas_info, contributions->half_count, contributions->covered,
                                       contributions->atlas_triangles + hit.triangle, side, hit.u, hit.v);
  for (uint k = 0u; k < BUNDLE_REFLECTED &&
                    (contributions->limit == LUCARIUM_NONE || k + 1u + chain->vertices <= contributions->limit);
       ++k)
    chain_light(contributions, chain->target, k + 1u + chain->vertices,
                chain->throughput.xyz * contributions->diffuse[sender * BUNDLE_REFLECTED + k].xyz);
  return true;
}

__kernel void advance_texel_chains(LUCARIUM_CHAIN_PARAMETERS AtlasInfo atlas_info,
                                   __global const AtlasTriangle* restrict atlas_triangles,
                                   __global const uint* restrict atlas_table,
                                   SIDE_HALVES_PARAMETERS __global const float4* restrict diffuse, uint layout,
                                   __global float4* restrict contribution) {
  Contributions contributions = {contribution, layout,  atlas_info, atlas_triangles, atlas_table,
                                 half_count,   covered, diffuse,    settings.limit};
  LUCARIUM_ADVANCE_CHAINS(&contributions);
}

__kernel void add_punctual(LUCARIUM_CHAIN_LIGHT_PARAMETERS uint layout, __global float4* restrict contribution) {
  Contributions contributions;
  contributions.contribution = contribution;
  contributions.layout = layout;
  LUCARIUM_ADD_CHAIN_LIGHT(&contributions);
}
