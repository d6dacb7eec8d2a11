// SPDX-License-Identifier: Apache-2.0
// Tables of triangles, materials and light for walks (shared/walk_tables.h).
#include "lucarium/bsdf.clh"
#include "lucarium/lights.clh"
#include "lucarium/medium.clh"
#include "lucarium/scene.clh"
#include "lucarium/surface_atlas.clh"
#include "virtual_light_field/shared/walk_tables.h"

#define MARGIN 1e-5f  // of cosines, for rounding

// Whether points of a material differ, or light on the way to them is absorbed.
bool needs_more(const Scene* scene, const __global Material* m) {
  const uint textures = m->base_color_texture.texture & m->metallic_roughness_texture.texture &
                        m->transmission_texture.texture & m->normal_texture.texture & m->emissive_texture.texture;
  const bool volume = (m->flags & LUCARIUM_MATERIAL_TRANSMISSIVE) && !(m->flags & LUCARIUM_MATERIAL_THIN);
  return textures != LUCARIUM_NONE || (m->flags & LUCARIUM_MATERIAL_VERTEX_COLOR) || volume;
}

// The largest sine between unit n and the normals of three corners, which those between them do not exceed; WALK_NEVER
// where one of them is more than a right angle off.
float sine_to_corners(float3 n, const __global Vertex* a, const __global Vertex* b, const __global Vertex* c) {
  const float3 na = safe_normalize(a->normal.xyz, n), nb = safe_normalize(b->normal.xyz, n),
               nc = safe_normalize(c->normal.xyz, n);
  if (fmin(dot(n, na), fmin(dot(n, nb), dot(n, nc))) <= 0.0f) return WALK_NEVER;
  return fmax(length(cross(n, na)), fmax(length(cross(n, nb)), length(cross(n, nc))));
}

__kernel void list_walk_triangles(LUCARIUM_SCENE_PARAMETERS __global const AtlasTriangle* restrict atlas_triangles,
                                  uint count, __global WalkTriangle* restrict walk_triangles) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  const Triangle triangle = scene.scene_triangles[i];
  const __global Vertex* a = scene.scene_vertices + triangle.v0;
  const __global Vertex* b = scene.scene_vertices + triangle.v1;
  const __global Vertex* c = scene.scene_vertices + triangle.v2;
  const float3 n = geometric_normal(a->position.xyz, b->position.xyz, c->position.xyz, (float3)(0.0f));
  WalkTriangle result;
  result.atlas = atlas_triangles[i];
  result.material = scene.scene_instances[triangle.instance].material;
  const bool never = is_black(fabs(n)) || needs_more(&scene, scene.scene_materials + result.material);
  result.normal_x = n.x;
  result.normal_y = n.y;
  result.normal_z = n.z;
  result.limit = never ? WALK_NEVER : sine_to_corners(n, a, b, c) + MARGIN;
  result.pad0 = result.pad1 = result.pad2 = 0u;
  walk_triangles[i] = result;
}

// Work-item 2 m + s: side s of material m.
__kernel void list_walk_sides(LUCARIUM_SCENE_PARAMETERS uint count, __global WalkSide* restrict walk_sides) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  Surface surface;
  surface.position = surface.ray_start = (float3)(0.0f);
  surface.n_g = surface.n_s = surface.view = (float3)(0.0f, 0.0f, 1.0f);
  surface.uv0 = surface.uv1 = (float2)(0.0f);
  surface.color = (float4)(1.0f);
  surface.ray_offset = 0.0f;
  surface.triangle = LUCARIUM_NONE;
  surface.material = i / 2u;
  surface.flags = i % 2u == 0u ? LUCARIUM_SURFACE_FRONT : 0u;
  const Bsdf bsdf = make_bsdf(&scene, &surface, LUCARIUM_BSDF_UNSAMPLED);
  const bool ideal = bsdf.flags & LUCARIUM_BSDF_DELTA;
  walk_sides[i].diffuse = (float4)(bsdf.diffuse, ideal ? 1.0f : 0.0f);
  walk_sides[i].emitted = (float4)(emitted_radiance(&scene, &surface), 0.0f);
}

// Of `count` entries, of which each texel side has one or two.
__kernel void list_walk_light(uint count, uint sides, uint fold, __global const float4* restrict shown,
                              __global const float4* restrict shown_direct, __global const float4* restrict side_albedo,
                              __global const uint* restrict side_facet, __global WalkLight* restrict walk_light) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const uint side = i < sides ? i : i - sides, facet = side_facet[side];
  const float3 coat = fold && facet == LUCARIUM_NONE ? side_albedo[side].xyz : (float3)(0.0f);
  walk_light[i].shown = shown[i];
  walk_light[i].direct = shown_direct[i];
  walk_light[i].coat = (float4)(coat, as_float(facet));
}
