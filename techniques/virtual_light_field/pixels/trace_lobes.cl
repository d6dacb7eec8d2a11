// SPDX-License-Identifier: Apache-2.0
// A ray per sample by the specular lobes of what a pixel shows, that looks up the field where it ends.
#include "lucarium/gbuffer.clh"
#include "lucarium/services/texel_sides/side_halves.clh"
#include "lucarium/surface_atlas.clh"
#include "virtual_light_field/tiles/field_lookup.clh"

typedef struct Found {
  __global float4* light;  // per pixel: direct, where the ray meets emitters, then the rest
  // Not set where only light samples are added.
  AtlasInfo atlas_info;
  const __global AtlasTriangle* atlas_triangles;
  const __global uint* atlas_table;
  const __global uchar* atlas_links;
  uint half_count;
  const __global uint* covered;
  const __global float4* held;
  const __global float4* side_albedo;
  const __global uint *direct, *total;  // cells
  uint split, fold;
  LightField field;
} Found;
#define CHAIN_CONSUMER Found
#include "lucarium/services/specular_chains/advance.clh"

void chain_light(Found* found, uint target, uint scatterings, float3 light) {
  found->light[2u * target + (scatterings > 1u)].xyz += light;
}

// The chain ends at the first surface: its diffuse light at full resolution, its coat as in propagation, or its tiles.
bool chain_surface(Found* found, const Scene* scene, const SpecularChain* chain, const Surface* surface, Hit hit) {
  const bool front = surface->flags & LUCARIUM_SURFACE_FRONT;
  const uint texel = atlas_texel(found->atlas_triangles, found->atlas_table, hit.triangle, hit.u, hit.v);
  const uint side = atlas_side(found->atlas_info, texel, front);
  if (side == LUCARIUM_NONE) return false;
  const AtlasNeighbours around = atlas_neighbours(found->atlas_info, found->atlas_triangles, found->atlas_table,
                                                  found->atlas_links, hit.triangle, hit.u, hit.v, front);
  const uint own = half_at(found->atlas_info, found->half_count, found->covered, found->atlas_triangles + hit.triangle,
                           side, hit.u, hit.v);
  const float4 held = held_or_other(found->atlas_info, found->half_count, own, &around, found->held,
                                    atlas_interpolated(&around, found->held + own));
  const Bsdf bsdf = make_bsdf(scene, surface, 0u);
  const uint facet = found->field.side_facet[side];
  float3 albedo = bsdf.diffuse, light = (float3)(0.0f);
  if (facet == LUCARIUM_NONE) {
    if (found->fold) albedo += found->side_albedo[side].xyz;
  } else {
    light = facet_radiance(&found->field, found->total, facet, surface->position, surface->view);
    if (found->split) light += facet_radiance(&found->field, found->direct, facet, surface->position, surface->view);
  }
  if (held.w > 0.0f) light += albedo * (held.xyz / held.w);
  chain_light(found, chain->target, chain->vertices + 1u, chain->throughput.xyz * light);
  return false;
}

__kernel void begin_rays(LUCARIUM_SCENE_PARAMETERS __global const GBufferPoint* restrict points, uint count,
                         ChainSettings settings, uint mirrors, __global float4* restrict light,
                         __global SpecularChain* restrict chains, __global Ray* restrict rays,
                         __global uint* restrict queue, __global uint* restrict active) {
  const uint i = get_global_id(0);
  if (i == 0u) active[0] = count;
  if (i >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  light[2u * i] = light[2u * i + 1u] = (float4)(0.0f);
  queue[i] = i;
  Ray ray = inactive_ray();
  const GBufferPoint point = points[i];
  if (point.state == LUCARIUM_GBUFFER_SURFACE) {
    const Surface surface = gbuffer_surface(&scene, point);
    const Bsdf full = make_bsdf(&scene, &surface, 0u);
    Bsdf bsdf = specular_part(full);
    // Ideal lobes belong to the G-buffer's path, or to tiles, which hold all lobes of the surface.
    const uint ideal = mirrors && bsdf.flags & LUCARIUM_BSDF_DELTA ? LUCARIUM_BSDF_DELTA : bsdf.flags;
    if (ideal & LUCARIUM_BSDF_DELTA_REFLECTION) bsdf.f0 = (float3)(0.0f), bsdf.f90 = 0.0f;
    if (ideal & LUCARIUM_BSDF_DELTA_TRANSMISSION) bsdf.transmission = (float3)(0.0f);
    choose_lobe_probabilities(&bsdf);
    SpecularChain chain = begin_chain(i, point.throughput.xyz, gbuffer_medium(point));
    if (!extend_chain(&scene, settings, &surface, &bsdf, &chain, &ray)) ray = inactive_ray();
    chains[i] = chain;
  }
  rays[i] = ray;
}

__kernel void advance_rays(LUCARIUM_CHAIN_PARAMETERS AtlasInfo atlas_info,
                           __global const AtlasTriangle* restrict atlas_triangles,
                           __global const uint* restrict atlas_table, __global const uchar* restrict atlas_links,
                           FIELD_LOOKUP_PARAMETERS SIDE_HALVES_PARAMETERS __global const float4* restrict held,
                           __global const float4* restrict side_albedo, __global const uint* restrict direct,
                           __global const uint* restrict total, uint split, uint fold,
                           __global float4* restrict light) {
  Found found = {light, atlas_info,  atlas_triangles, atlas_table, atlas_links, half_count, covered,
                 held,  side_albedo, direct,          total,       split,       fold,       FIELD_LOOKUP_BIND};
  LUCARIUM_ADVANCE_CHAINS(&found);
}

__kernel void add_ray_light(LUCARIUM_CHAIN_LIGHT_PARAMETERS __global float4* restrict light) {
  Found found;
  found.light = light;
  LUCARIUM_ADD_CHAIN_LIGHT(&found);
}
