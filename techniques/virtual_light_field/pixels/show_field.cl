// SPDX-License-Identifier: Apache-2.0
// What the field shows at the points of a G-buffer: at most 4 + 12 look-ups for a pixel, however much light there is.
#include "lucarium/atlas_light.clh"
#include "lucarium/bsdf.clh"
#include "lucarium/scene.clh"
#include "lucarium/services/layer_sums/layer_sums.clh"
#include "virtual_light_field/tiles/field_lookup.clh"

// Adds a sample that counts `weight` of the mean: a field that has grown replaces what it was. traced: light of rays by
// specular lobes, direct and other (trace_lobes.cl). They count where `rays`. lobes: 1: tiles, and coats as in
// propagation, are looked up at pixels. mirrors: 1: tiles of ideal lobes.
// atlas_direct: 1: direct light is the atlas's.
__kernel void show_field(LUCARIUM_SCENE_PARAMETERS AtlasInfo atlas_info,
                         __global const AtlasTriangle* restrict atlas_triangles,
                         __global const uint* restrict atlas_table, __global const uchar* restrict atlas_links,
                         FIELD_LOOKUP_PARAMETERS __global const GBufferPoint* restrict points, uint count, float weight,
                         uint lobes, uint mirrors, uint rays, uint atlas_direct, uint split, uint fold,
                         __global const float4* restrict side_albedo, __global const float4* restrict shown_direct,
                         __global const float4* restrict shown, __global const uint* restrict direct,
                         __global const uint* restrict total, __global const float4* restrict traced,
                         __global float4* restrict direct_layer, __global float4* restrict indirect_layer) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  const LightField field = FIELD_LOOKUP_BIND;
  const GBufferPoint point = points[i];
  float3 once = (float3)(0.0f), more = once;
  if (rays) {
    once = traced[2u * i].xyz;
    more = traced[2u * i + 1u].xyz;
  }
  if (point.state == LUCARIUM_GBUFFER_SURFACE) {
    const AtlasNeighbours around = atlas_around(atlas_info, atlas_triangles, atlas_table, atlas_links, &point);
    const uint side = around.side[0], facet = side == LUCARIUM_NONE ? LUCARIUM_NONE : side_facet[side];
    float3 albedo = gbuffer_diffuse(point), coat = (float3)(0.0f);
    if (fold && side != LUCARIUM_NONE && facet == LUCARIUM_NONE) coat = side_albedo[side].xyz;
    // Ideal lobes are the G-buffer's, unless it keeps first surfaces; rough ones those of rays.
    bool ideal = false, shows = false;
    if ((lobes || mirrors) && (facet != LUCARIUM_NONE || !is_black(coat))) {
      const Surface surface = gbuffer_surface(&scene, point);
      const Bsdf bsdf = make_bsdf(&scene, &surface, 0u);
      ideal = bsdf.flags & LUCARIUM_BSDF_DELTA_REFLECTION;
      shows = ideal ? mirrors : lobes;
    }
    if (shows) albedo += coat;
    // Diffuse light.
    float3 more_here = (float3)(0.0f), once_here = more_here;
    add_irradiance_at(&around, shown, albedo, &more_here);
    if (atlas_direct) add_irradiance_at(&around, shown_direct, albedo, &once_here);
    // Specular lobes.
    if (ideal && shows && facet != LUCARIUM_NONE) {
      // What a mirror shows is light that it has scattered, of lamps too: no sample of the pixel finds it.
      more_here += facet_radiance(&field, total, facet, point.position.xyz, point.view.xyz);
      if (split) more_here += facet_radiance(&field, direct, facet, point.position.xyz, point.view.xyz);
    } else if (shows && facet != LUCARIUM_NONE) {
      more_here += facet_radiance(&field, total, facet, point.position.xyz, point.view.xyz);
      if (atlas_direct && split) once_here += facet_radiance(&field, direct, facet, point.position.xyz, point.view.xyz);
    }
    once += point.throughput.xyz * once_here;
    more += point.throughput.xyz * more_here;
  }
  direct_layer[i] = mix_sample(direct_layer[i], once, weight);
  indirect_layer[i] = mix_sample(indirect_layer[i], more, weight);
}
