// SPDX-License-Identifier: Apache-2.0
// Texel sides of the surface atlas from the scene as it is: sample positions, areas, what the surface scatters and
// emits.
#include "lucarium/atlas_surface.clh"
#include "lucarium/bsdf.clh"
#include "lucarium/lights.clh"
#include "lucarium/scene.clh"
#include "lucarium/shared/surface_point.h"
#include "lucarium/surface_atlas.clh"

float triangle_area(const __global Vertex* vertices, Triangle triangle) {
  const float3 a = vertices[triangle.v0].position.xyz;
  return 0.5f * length(cross(vertices[triangle.v1].position.xyz - a, vertices[triangle.v2].position.xyz - a));
}

// Position, normal and area of every side. A texel's pieces keep their fractions of the triangles, since a triangle's
// uv follow it affinely.
__kernel void place_atlas_sides(__global const Vertex* restrict scene_vertices,
                                __global const Triangle* restrict scene_triangles, AtlasInfo atlas_info,
                                __global const uint2* restrict atlas_ranges,
                                __global const TexelPiece* restrict atlas_pieces,
                                __global AtlasTexel* restrict atlas_texels,
                                __global SurfacePoint* restrict atlas_points) {
  const uint side = get_global_id(0);
  if (side >= atlas_info.texel_count) return;
  // Sum the areas of its pieces.
  const uint2 range = atlas_ranges[side];
  float area = 0.0f;
  for (uint i = range.x; i < range.x + range.y; ++i)
    area += atlas_pieces[i].fraction * triangle_area(scene_vertices, scene_triangles[atlas_pieces[i].triangle]);
  AtlasTexel texel = atlas_texels[side];
  texel.area = area;
  atlas_texels[side] = texel;

  // Place its point; a triangle without area takes the interpolated normal.
  const Triangle triangle = scene_triangles[texel.triangle];
  const Vertex a = scene_vertices[triangle.v0], b = scene_vertices[triangle.v1], c = scene_vertices[triangle.v2];
  const float3 interpolated = interpolate3(a.normal.xyz, b.normal.xyz, c.normal.xyz, texel.b1, texel.b2);
  const float3 fallback = safe_normalize(interpolated, (float3)(0.0f, 1.0f, 0.0f));
  const float3 normal = geometric_normal(a.position.xyz, b.position.xyz, c.position.xyz, fallback);
  SurfacePoint point;
  point.position = (float4)(a.position.xyz + texel.b1 * (b.position.xyz - a.position.xyz) +
                                texel.b2 * (c.position.xyz - a.position.xyz),
                            0.0f);
  point.normal = (float4)(atlas_side_is_front(atlas_info, side) ? normal : -normal, 0.0f);
  point.u = texel.b1;
  point.v = texel.b2;
  point.triangle = texel.triangle;
  point.flags = 0u;
  atlas_points[side] = point;
}

// The BSDF and the emission at every texel side, seen along its normal; whether it transmits.
__kernel void shade_atlas_sides(LUCARIUM_SCENE_PARAMETERS AtlasInfo atlas_info,
                                __global SurfacePoint* restrict atlas_points,
                                __global AtlasMaterial* restrict atlas_materials) {
  const uint side = get_global_id(0);
  if (side >= atlas_info.texel_count) return;
  LUCARIUM_SCENE_BIND(scene);
  const SurfacePoint point = atlas_points[side];
  const Surface surface = atlas_surface(&scene, atlas_info, side, point.triangle, point.u, point.v);
  const Bsdf bsdf = make_bsdf(&scene, &surface, 0u);
  AtlasMaterial material;
  material.diffuse = (float4)(bsdf.diffuse, bsdf.alpha);
  material.f0 = (float4)(bsdf.f0, bsdf.f90);
  material.transmission = (float4)(bsdf.transmission, bsdf.eta);
  material.emission = (float4)(emitted_radiance(&scene, &surface), bsdf.flags & LUCARIUM_BSDF_DELTA ? 1.0f : 0.0f);
  material.shading = (float4)(surface.n_s, bsdf.dielectric_f0);
  atlas_materials[side] = material;
  atlas_points[side].flags = luminance(bsdf.transmission) > 0.0f ? LUCARIUM_POINT_TRANSMITS : 0u;
}
