// SPDX-License-Identifier: Apache-2.0
// A parallel subfield as a picture (Mortensen et al. 2007, figure 2): what leaves the scene along a line of the field,
// cell by cell. The subfield fills the largest square in the middle of the image.
#include "lucarium/atlas_light.clh"
#include "lucarium/ray_ends.clh"
#include "lucarium/scene.clh"
#include "lucarium/services/texel_sides/side_halves.clh"
#include "lucarium/shared/ray.h"
#include "lucarium/surface_point.clh"
#include "virtual_light_field/tiles/field_lookup.clh"

// Subfield coordinates [cells] of an image's pixel; outside of [0, subfield) beside the subfield.
float2 subfield_of_pixel(uint i, uint width, uint height, uint subfield) {
  const float side = (float)min(width, height);
  const float2 pixel = (float2)((float)(i % width), (float)(i / width)) + 0.5f;
  const float2 corner = 0.5f * ((float2)((float)width, (float)height) - side);
  return (pixel - corner) * ((float)subfield / side);
}

bool on_subfield(float2 at, uint subfield) {
  return at.x >= 0.0f && at.y >= 0.0f && at.x < (float)subfield && at.y < (float)subfield;
}

// Work-item: a pixel. The ray begins outside of the scene, at depth `reach` along omega [m], and runs against omega.
__kernel void aim_along_line(uint count, uint width, uint height, FieldInfo info,
                             __global const FieldLine* restrict lines, uint line, float reach, uint seed,
                             LUCARIUM_RAY_ENDS_PARAMETER(ends) __global Ray* restrict rays) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const FieldLine own = lines[line];
  const float2 at = subfield_of_pixel(i, width, height, info.subfield);
  Ray ray;
  const float2 off = (at - (float2)(own.row_x.w, own.row_y.w)) * info.cell * info.cell;
  const float3 origin = off.x * own.row_x.xyz + off.y * own.row_y.xyz + reach * own.omega.xyz;
  ray.origin = (float4)(origin, as_float(seed | 1u));
  ray.direction = (float4)(-own.omega.xyz, on_subfield(at, info.subfield) ? INFINITY : -1.0f);
  rays[i] = ray;
  LUCARIUM_STORE_RAY_ENDS(ends, i, no_ray_ends());
}

// What the nearest surface sends: emission, diffuse light, and its own cell of the line's subfield, not interpolated.
__kernel void show_subfield(
    LUCARIUM_SCENE_PARAMETERS AtlasInfo atlas_info, __global const AtlasTriangle* restrict atlas_triangles,
    __global const uint* restrict atlas_table, __global const AtlasMaterial* restrict atlas_materials, FieldInfo info,
    __global const FieldLine* restrict lines, __global const uint* restrict nodes,
    __global const uint* restrict side_facet, __global const FieldMap* restrict maps,
    __global const uint* restrict tile_cells, __global const float* restrict inverse_scale, uint split, uint fold,
    __global const float4* restrict side_albedo, SIDE_HALVES_PARAMETERS __global const float4* restrict shown_direct,
    __global const float4* restrict shown, __global const uint* restrict direct, __global const uint* restrict total,
    uint count, uint width, uint height, uint line, __global const Ray* restrict rays,
    __global const Hit* restrict hits, __global float4* restrict layer) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  layer[i] = (float4)(0.0f, 0.0f, 0.0f, 1.0f);
  // Find the texel side that the pixel shows.
  const Hit hit = hits[i];
  if (hit.triangle == LUCARIUM_NO_HIT) return;
  LUCARIUM_SCENE_BIND(scene);
  const Surface surface = surface_hit_from(&scene, hit.triangle, hit.u, hit.v, rays[i].direction.xyz);
  const uint texel = atlas_texel(atlas_triangles, atlas_table, hit.triangle, hit.u, hit.v);
  const uint side = atlas_side(atlas_info, texel, surface.flags & LUCARIUM_SURFACE_FRONT);
  if (side == LUCARIUM_NONE) return;
  // Add what its cell sends; lobes that are folded have no cells.
  float3 light = atlas_materials[side].emission.xyz;
  float3 albedo = atlas_materials[side].diffuse.xyz;
  const uint facet = side_facet[side];
  if (facet != LUCARIUM_NONE) {
    const float2 at = floor(subfield_of_pixel(i, width, height, info.subfield));
    const uint cell = find_cell(maps[(size_t)(2u * line) * info.facets + facet], tile_cells, (int)at.x, (int)at.y);
    if (cell != LUCARIUM_NONE && FIELD_MAP_LEVEL(maps[facet]) == 0u && total[cell] != FIELD_NO_CELL) {
      light += inverse_scale[0] * unpack_rgb9e5(total[cell]);
      if (split) light += inverse_scale[0] * unpack_rgb9e5(direct[cell]);
    }
    // A facet of a coarser grid has cells of its directions alone.
    if (FIELD_MAP_LEVEL(maps[facet]) > 0u) {
      const LightField field = {info, lines, nodes, side_facet, maps, tile_cells, inverse_scale[0], 0u};
      light += facet_radiance(&field, total, facet, surface.position, lines[line].omega.xyz);
      if (split) light += facet_radiance(&field, direct, facet, surface.position, lines[line].omega.xyz);
    }
  } else if (fold) {
    albedo += side_albedo[side].xyz;
  }
  // Add its diffuse light.
  const uint own = half_at(atlas_info, half_count, covered, atlas_triangles + hit.triangle, side, hit.u, hit.v);
  const AtlasNeighbours alone = {{side, LUCARIUM_NONE, LUCARIUM_NONE, LUCARIUM_NONE}, {1.0f, 0.0f, 0.0f, 0.0f}};
  const float4 once = held_or_other(atlas_info, half_count, own, &alone, shown_direct, shown_direct[own + side]);
  const float4 more = held_or_other(atlas_info, half_count, own, &alone, shown, shown[own + side]);
  layer[i].xyz = light + reflected_irradiance(once, albedo) + reflected_irradiance(more, albedo);
}
