// SPDX-License-Identifier: Apache-2.0
// What facets send towards every direction of what they have received from all: mirrors, glossy lobes, refraction
// (Mortensen et al. 2007, section 3.4; there by splats: splat_lobes.clh). Each cell is gathered: it is written once,
// without atomics, and with normalised weights a uniform field stays what it is.
#include "lucarium/atlas_surface.clh"
#include "lucarium/random.clh"
#include "lucarium/scene.clh"
#include "lucarium/shared/surface_point.h"
#include "lucarium/specular_albedo.clh"
#include "virtual_light_field/directions/direction_grid.clh"
#include "virtual_light_field/scatter/norms.clh"
#include "virtual_light_field/scatter/punctual_light.clh"
#include "virtual_light_field/scatter/side_lobes.clh"
#include "virtual_light_field/scatter/splat_lobes.clh"
#include "virtual_light_field/tiles/subfield_cells.clh"

#define LOBE_CUT 1e-3f  // of the largest value of a lobe: what is below does not count
// A lobe counts as ideal whose GGX width alpha is below both limits; wider ones have tails, which an ideal one lacks.
#define NARROW 0.5f       // share of the spacing of directions
#define MAX_NARROW 0.07f  // alpha [1]
#define NEAREST_STEPS 4   // tries to find a covered direction

// What facets have received.
typedef struct Incoming {
  FieldInfo info;
  const __global FieldLine* lines;
  const __global uint* nodes;
  const __global FieldMap* maps;
  const __global uint* tile_cells;
  const __global uint* cells;
} Incoming;

// Radiance that comes to a point of a facet from a direction of the grid; w 0: not known.
float4 incoming_radiance(const Incoming* in, uint facet, uint direction, float3 position) {
  const FieldMap map = in->maps[(size_t)direction * in->info.facets + facet];
  if (FIELD_MAP_WIDTH(map) == 0u) return (float4)(0.0f);
  return subfield_radiance(map, in->tile_cells, in->cells, subfield_point(in->lines[direction >> 1], position));
}

// The same from any direction, by the nodes around it: sum b L / sum b over those that are known.
float4 interpolated_radiance(const Incoming* in, uint facet, float3 from, float3 position) {
  const GridLookup lookup = look_up_direction_of(in->info, in->nodes, from, FIELD_MAP_LEVEL(in->maps[facet]));
  float4 sum = (float4)(0.0f);
  for (int q = 0; q < 3; ++q) {
    if (!(lookup.weight[q] > 0.0f)) continue;
    const float4 radiance = incoming_radiance(in, facet, lookup.direction[q], position);
    if (radiance.w > 0.0f) sum += lookup.weight[q] * (float4)(radiance.xyz, 1.0f);
  }
  return sum.w > 0.0f ? (float4)(sum.xyz / sum.w, 1.0f) : (float4)(0.0f);
}

// Where the facet does not know any of them, the nearest direction towards `inwards` that it knows.
float3 ideal_radiance(const Incoming* in, uint facet, float3 from, float3 inwards, float3 position) {
  for (int step = 0; step <= NEAREST_STEPS; ++step) {
    const float3 tried = normalize(from + (float)step * in->info.angle * inwards);
    const float4 radiance = interpolated_radiance(in, facet, tried, position);
    if (radiance.w > 0.0f) return radiance.xyz;
  }
  return (float3)(0.0f);
}

// The same by splats; w 0: no direction brings anything.
float4 splat_radiance(const Incoming* in, const Splats* splats, const Bsdf* bsdf, uint facet, bool transmitted,
                      float3 from, float3 position) {
  const float reach = SPLAT_REACH * in->info.angle * (transmitted ? SPLAT_SPREAD : 1.0f);
  const float nearest = cos(fmin(reach, M_PI_F));
  float4 sum = (float4)(0.0f);
  for (uint i = 0u; i < 2u * in->info.lines; ++i) {
    if (dot(field_direction(in->lines, i), from) < nearest) continue;
    const float weight = splat_weight(splats, in->info, in->lines, in->nodes, bsdf, i, transmitted);
    if (!(weight > 0.0f)) continue;
    const float4 radiance = incoming_radiance(in, facet, i, position);
    if (radiance.w > 0.0f) sum += weight * (float4)(radiance.xyz, 1.0f);
  }
  return sum;
}

// Radiance of an ideal lobe that shows what comes from `from`, on the side of `inwards`.
float3 lobe_radiance(const Incoming* in, const Splats* splats, const Bsdf* bsdf, uint facet, bool transmitted,
                     float3 from, float3 inwards, float3 position) {
  if (splats) {
    const float4 sum = splat_radiance(in, splats, bsdf, facet, transmitted, from, position);
    if (!splats->means) return sum.xyz;
    if (sum.w > 0.0f) return sum.xyz / sum.w;
  }
  return ideal_radiance(in, facet, from, inwards, position);
}

// Albedos of the rough lobes. Of opaque surfaces and thin walls exactly: a thin wall transmits by the reflection lobe
// mirrored, with 1 - F for F. Of volumes F is taken at the surface's own normal, with total reflection from inside.
float3 reflection_albedo(const Scene* scene, const Bsdf* bsdf) {
  const float cos_v = dot(bsdf->n_s, bsdf->view);
  const float2 e = specular_albedo_directional(scene->scene_albedo_table, cos_v, sqrt(bsdf->alpha));
  if (bsdf->eta != 1.0f) return e.x * fresnel_reflection(bsdf, schlick_weight(bsdf->eta, cos_v));
  return bsdf->f0 * (e.x - e.y) + bsdf->f90 * e.y;
}
float3 transmission_albedo(const Scene* scene, const Bsdf* bsdf) {
  const float cos_v = dot(bsdf->n_s, bsdf->view);
  const float2 e = specular_albedo_directional(scene->scene_albedo_table, cos_v, sqrt(bsdf->alpha));
  if (bsdf->eta != 1.0f) {
    const float passed = fresnel_transmission(bsdf, schlick_weight(bsdf->eta, cos_v));
    return bsdf->transmission * (e.x * passed * bsdf->eta * bsdf->eta);
  }
  return bsdf->transmission * ((1.0f - bsdf->dielectric_f0) * (e.x - e.y) + (1.0f - bsdf->dielectric_f90) * e.y);
}

// A glossy lobe (out_j of virtual_light_field.cpp): a sum g L / sum g, g = f |cos| dOmega, over the directions that the
// facet knows.
float3 rough_light(const Incoming* in, const Scene* scene, const Bsdf* bsdf, uint facet, uint behind, float3 position) {
  float3 light = (float3)(0.0f), share = light, through = light, passed = light;
  const bool reflects = bsdf->p_reflect > 0.0f && !(bsdf->flags & LUCARIUM_BSDF_DELTA_REFLECTION);
  const bool transmits =
      behind != LUCARIUM_NONE && bsdf->p_transmit > 0.0f && !(bsdf->flags & LUCARIUM_BSDF_DELTA_TRANSMISSION);
  // D(h) >= LOBE_CUT D(n), as a bound on the squared cosine of h (ggx.clh).
  const float a2 = bsdf->alpha * bsdf->alpha;
  const float cut = fmax(1.0f - a2 * rsqrt(LOBE_CUT), 0.0f) / fmax(1.0f - a2, 1e-6f);
  const bool coarse = FIELD_MAP_LEVEL(in->maps[facet]) > 0u;
  // Add directions of which the lobe reflects or transmits a noticeable part.
  for (uint direction = 0u; direction < 2u * in->info.lines; ++direction) {
    const float3 l = field_direction(in->lines, direction);
    const bool above = dot(bsdf->n_s, l) > 0.0f;
    if (above ? !reflects : !transmits) continue;
    const FieldMap map = in->maps[(size_t)direction * in->info.facets + (above ? facet : behind)];
    if (coarse && FIELD_MAP_WIDTH(map) == 0u) continue;
    if (above) {
      const float3 h = bsdf->view + l;
      const float along = dot(bsdf->n_s, h);
      if (along * along < cut * dot(h, h)) continue;
    }
    const float3 g = eval_bsdf(bsdf, l) * in->lines[direction >> 1].omega.w;
    if (is_black(g)) continue;
    const float4 radiance = incoming_radiance(in, above ? facet : behind, direction, position);
    if (!(radiance.w > 0.0f)) continue;
    if (above) {
      light += g * radiance.xyz;
      share += g;
    } else {
      through += g * radiance.xyz;
      passed += g;
    }
  }
  // Where no direction lies within a lobe, it shows what an ideal one does.
  const float cos_out = dot(bsdf->n_s, bsdf->view);
  if (reflects && is_black(share)) {
    const float3 from = normalize(2.0f * cos_out * bsdf->n_s - bsdf->view);
    share = (float3)(dot(bsdf->n_g, from) > 0.0f ? 1.0f : 0.0f);
    if (share.x > 0.0f) light = ideal_radiance(in, facet, from, bsdf->n_g, position);
  }
  if (transmits && is_black(passed) && schlick_weight(bsdf->eta, cos_out) >= 0.0f) {
    const bool straight = bsdf->flags & LUCARIUM_BSDF_THIN;
    const float3 from = straight ? -bsdf->view : refract_at(bsdf->view, bsdf->n_s, bsdf->eta);
    passed = (float3)(dot(bsdf->n_g, from) < 0.0f ? 1.0f : 0.0f);
    if (passed.x > 0.0f) through = ideal_radiance(in, behind, from, -bsdf->n_g, position);
  }
  // Scale the means by the albedo of each lobe.
  float3 sum = (float3)(0.0f);
  if (reflects) sum += reflection_albedo(scene, bsdf) * select((float3)(0.0f), light / share, share > 0.0f);
  if (transmits) sum += transmission_albedo(scene, bsdf) * select((float3)(0.0f), through / passed, passed > 0.0f);
  return sum;
}

// Radiance that a facet sends towards bsdf->view. behind: the facet of the other side, LUCARIUM_NONE: none.
// splats: null: ideal lobes are gathered.
float3 scattered_light(const Incoming* in, const Scene* scene, const Splats* splats, const Bsdf* bsdf, uint facet,
                       uint behind, float3 position) {
  if (bsdf_is_black(bsdf)) return (float3)(0.0f);
  const bool narrow = bsdf->alpha < fmin(NARROW * in->info.angle, MAX_NARROW);
  const float cos_v = dot(bsdf->n_s, bsdf->view), schlick = schlick_weight(bsdf->eta, cos_v);
  float3 light = (float3)(0.0f);
  // Reflect what comes from the mirror direction.
  if (bsdf->p_reflect > 0.0f && (narrow || (bsdf->flags & LUCARIUM_BSDF_DELTA_REFLECTION))) {
    const float3 from = normalize(2.0f * cos_v * bsdf->n_s - bsdf->view);
    const float3 albedo = bsdf->alpha > 0.0f ? reflection_albedo(scene, bsdf) : fresnel_reflection(bsdf, schlick);
    if (dot(bsdf->n_g, from) > 0.0f)
      light += albedo * lobe_radiance(in, splats, bsdf, facet, false, from, bsdf->n_g, position);
  }
  // Transmit what comes from the refracted direction.
  if (behind != LUCARIUM_NONE && bsdf->p_transmit > 0.0f && schlick >= 0.0f &&
      (narrow || (bsdf->flags & LUCARIUM_BSDF_DELTA_TRANSMISSION))) {
    const bool straight = bsdf->flags & LUCARIUM_BSDF_THIN;
    const float3 from = straight ? -bsdf->view : refract_at(bsdf->view, bsdf->n_s, bsdf->eta);
    const float3 tint = bsdf->alpha > 0.0f && !(bsdf->flags & LUCARIUM_BSDF_DELTA_TRANSMISSION)
                            ? transmission_albedo(scene, bsdf)
                            : bsdf->transmission * (fresnel_transmission(bsdf, schlick) * bsdf->eta * bsdf->eta);
    // Sums of splats bring the change of radiance with the index themselves.
    const float power = splats && !splats->means ? 1.0f / (bsdf->eta * bsdf->eta) : 1.0f;
    if (dot(bsdf->n_g, from) < 0.0f)
      light += tint * power * lobe_radiance(in, splats, bsdf, behind, true, from, -bsdf->n_g, position);
  }
  if (!narrow) light += rough_light(in, scene, bsdf, facet, behind, position);
  return light;
}

// The map (direction-major) that an entry of the tile table belongs to: the last one that does not begin behind it.
uint map_of_entry(const __global FieldMap* maps, uint count, uint entry) {
  uint low = 0u;
  for (uint length = count; length > 1u;) {
    const uint half_length = length >> 1;
    low = maps[low + half_length].first <= entry ? low + half_length : low;
    length -= half_length;
  }
  return low;
}

// The cells of a tile, or of a row of cells (store=csr).
typedef struct TileCells {
  uint map;           // direction facets + facet
  uint first, count;  // cells
  uint x, y, width;   // subfield coordinates of the first cell; cells of a row
} TileCells;

TileCells cells_of_entry(FieldInfo info, const __global FieldMap* maps, const __global uint* tile_cells, uint entry) {
  TileCells tile;
  tile.map = map_of_entry(maps, 2u * info.lines * info.facets, entry);
  tile.first = tile_cells[entry];
  const FieldMap map = maps[tile.map];
  const uint m = FIELD_MAP_TILE(map), w = FIELD_MAP_WIDTH(map), place = entry - map.first;
  if (m == 0u) {
    const uint span = tile_cells[entry + 1u];
    tile.x = span & 0xffffu;
    tile.y = (map.corner >> 16) + place / 2u;
    tile.width = tile.count = span >> 16;
  } else {
    tile.x = (map.corner & 0xffffu) + place % w * m;
    tile.y = (map.corner >> 16) + place / w * m;
    tile.width = m;
    tile.count = m * m;
  }
  return tile;
}

// Work-item i: FIELD_TILE_CHUNK tiles of the list, from first_tile + FIELD_TILE_CHUNK i on. incoming: of the sweep that
// ended. sent: what was sent in it, and must be in the next. Stored radiance is RGB9E5 over inverse_scale. direct,
// total: as before (add_cells()). lights, visible: see punctual_highlights(); visible of each texel side. splat: 0,
// SPLAT_MEANS or SPLAT_SUMS. subfields, perturb: see Splats. norms: of each chunk of tiles. The hint keeps Intel's
// compiler from vectorizing over work-items, where it crashes (2026.2); it says nothing to others.
__kernel __attribute__((vec_type_hint(float4))) void scatter_cells(
    LUCARIUM_SCENE_PARAMETERS AtlasInfo atlas_info, __global const SurfacePoint* restrict atlas_points,
    __global const AtlasMaterial* restrict atlas_materials, FieldInfo info, __global const FieldLine* restrict lines,
    __global const uint* restrict nodes, __global const uint* restrict side_facet,
    __global const FieldMap* restrict maps, __global const uint* restrict tile_cells,
    __global const uint* restrict tile_list, uint first_tile, uint tiles, uint sweep, uint split, uint splat,
    __global const float4* restrict subfields, uint perturb, float inverse_scale, float scale,
    __global const uint* restrict lights, __global const uint* restrict visible,
    __global const uint* restrict cell_side, __global const uint* restrict incoming, __global uint* restrict sent,
    __global uint* restrict total, __global uint* restrict direct, __global float4* restrict norms) {
  const uint first = first_tile + FIELD_TILE_CHUNK * (uint)get_global_id(0);
  if (first >= tiles) return;
  LUCARIUM_SCENE_BIND(scene);
  const Incoming in = {info, lines, nodes, maps, tile_cells, incoming};
  float4 sums[FIELD_NORMS];
  for (uint k = 0u; k < FIELD_NORMS; ++k) sums[k] = (float4)(0.0f);
  for (uint i = first; i < min(first + FIELD_TILE_CHUNK, tiles); ++i) {
    const TileCells tile = cells_of_entry(info, maps, tile_cells, tile_list[i]);
    const uint direction = tile.map / info.facets, facet = tile.map - direction * info.facets;
    const FieldLine line = lines[direction >> 1];
    const float3 view = field_direction(lines, direction);
    const Splats splats = {subfields, perturb, direction, splat == SPLAT_MEANS};
    // A direction of a grid of m = n / 2^level stands for (2 n^2 + 1) / (2 m^2 + 1) of all.
    const uint coarse = info.grid >> FIELD_MAP_LEVEL(maps[facet]);
    const float measure =
        info.cell * info.cell * line.omega.w * ((float)info.lines / (float)(2u * coarse * coarse + 1u));
    for (uint k = 0u; k < tile.count; ++k) {
      // Pass over cells of the tile that show nothing.
      const uint cell = tile.first + k, side = cell_side[cell];
      if (side == LUCARIUM_NONE) {
        sent[cell] = FIELD_NO_CELL;
        continue;
      }
      // Find the cell's point, its lobes towards the direction, and the facet behind it.
      const SurfacePoint point = atlas_points[side];
      const float2 at = (float2)((float)(tile.x + k % tile.width) + 0.5f, (float)(tile.y + k / tile.width) + 0.5f);
      const float3 position =
          subfield_hit(line, at, info.cell, point.position.xyz, point.normal.xyz, CELL_REACH * info.texel_edge);
      const Bsdf bsdf = side_lobes(atlas_materials + side, point.normal.xyz, view);
      const uint k_sides = atlas_info.double_sided_count;
      const uint other = side < k_sides ? side + k_sides : side < 2u * k_sides ? side - k_sides : LUCARIUM_NONE;
      const uint behind = other == LUCARIUM_NONE ? LUCARIUM_NONE : side_facet[other];
      // Gather what comes by the lobes; in the first sweep also highlights of punctual lights.
      float3 now = scattered_light(&in, &scene, splat ? &splats : 0, &bsdf, facet, behind, position);
      if (sweep == 0u) now += scale * punctual_highlights(&scene, &bsdf, lights, visible[side], position);
      // Store it for the next sweep; measure how much it changes.
      float3 before = (float3)(0.0f), sum = now;
      if (sweep > 0u) {
        before = unpack_rgb9e5(sent[cell]);
        sum += unpack_rgb9e5(total[cell]);
        if (split) sum += unpack_rgb9e5(direct[cell]);
      }
      sent[cell] = pack_cell(now);
      add_norms(sums, measure, inverse_scale * now, inverse_scale * before, inverse_scale * sum);
    }
  }
  for (uint k = 0u; k < FIELD_NORMS; ++k) norms[(size_t)(first / FIELD_TILE_CHUNK) * FIELD_NORMS + k] = sums[k];
}

// Adds what is sent next to the totals of cells, and with it the tail of the series, `tail` times as much. split: after
// the first sweep it is direct light, which is kept apart.
__kernel void add_cells(uint count, uint sweep, uint split, float4 tail, __global const uint* restrict sent,
                        __global uint* restrict direct, __global uint* restrict total) {
  const uint cell = get_global_id(0);
  if (cell >= count) return;
  const uint bits = sent[cell];
  if (sweep == 0u && split) {
    direct[cell] = bits;
    total[cell] = bits == FIELD_NO_CELL ? bits : 0u;
    return;
  }
  if (bits == FIELD_NO_CELL) {
    total[cell] = bits;
    return;
  }
  const float3 before = sweep == 0u ? (float3)(0.0f) : unpack_rgb9e5(total[cell]);
  const float random = uint_to_unit(hash_uint3(cell, sweep, 0x746f7461u));
  total[cell] = pack_cell_dithered(before + (1.0f + tail.xyz) * unpack_rgb9e5(bits), random);
}
