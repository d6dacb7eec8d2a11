// SPDX-License-Identifier: Apache-2.0
#include "lucarium/camera.clh"
#include "lucarium/path_vertex.clh"
#include "lucarium/scene.clh"

// The surface of a triangle's middle seen from `view`.
Surface seen_from(const Scene* scene, uint triangle, float3 view) {
  const Hit hit = {1.0f, triangle, 0.3f, 0.3f};
  return make_surface(scene, hit, -view, 0u);
}

float8 bsdf_values(const Bsdf* bsdf, float3 light) {
  float pdf;
  const float3 value = eval_bsdf_pdf(bsdf, light, &pdf);
  return (float8)(value, pdf, bsdf->p_reflect, bsdf->p_diffuse, bsdf->p_transmit, bsdf->eta);
}

// Pair i of directions: the BSDF made for `from` and turned to `to`, beside the one that is made for `to`.
kernel void turn_and_make(LUCARIUM_SCENE_PARAMETERS const uint triangle, const uint count,
                          const global float4* directions, global float* turned, global float* made) {
  LUCARIUM_SCENE_BIND(scene);
  const uint i = get_global_id(0);
  if (i >= count) return;
  const float3 from = directions[3u * i].xyz, to = directions[3u * i + 1u].xyz, light = directions[3u * i + 2u].xyz;
  const Surface here = seen_from(&scene, triangle, from), there = seen_from(&scene, triangle, to);
  const Bsdf first = make_bsdf(&scene, &here, 0u), second = make_bsdf(&scene, &there, 0u);
  const Bsdf other = turn_bsdf(&first, to);
  vstore8(bsdf_values(&other, light), i, turned);
  vstore8(bsdf_values(&second, light), i, made);
}

// The same of the BSDF stored in a vertex and read back; flags: number, medium, triangle, where rays end.
kernel void store_and_make(LUCARIUM_SCENE_PARAMETERS const uint triangle, const uint count,
                           const global float4* directions, global float* stored, global float* made,
                           global uint4* flags, global float4* ends) {
  LUCARIUM_SCENE_BIND(scene);
  const uint i = get_global_id(0);
  if (i >= count) return;
  const float3 from = directions[3u * i].xyz, light = directions[3u * i + 2u].xyz;
  const Surface here = seen_from(&scene, triangle, from);
  const Bsdf bsdf = make_bsdf(&scene, &here, 0u);
  const PathMis mis = {0.25f, 7.0f};
  const PathVertex vertex = pack_path_vertex(&here, &bsdf, (float3)(3.0f, 2.0f, 1.0f), 11u, 5u, mis);
  const Bsdf back = path_vertex_bsdf(&vertex);
  vstore8(bsdf_values(&back, light), i, stored);
  vstore8(bsdf_values(&bsdf, light), i, made);
  const PathMis kept = path_vertex_mis(&vertex);
  flags[i] = (uint4)(path_vertex_number(&vertex), path_vertex_medium(&vertex), path_vertex_ray_end(&vertex, light),
                     kept.fixed == 0.25f && kept.turning == 7.0f);
  // How far the end is off the triangle, on the side of `light`, over the offset of rays there.
  ends[i] =
      (float4)(dot(path_vertex_end(&vertex, light) - here.ray_start, here.n_g) / here.ray_offset, vertex.flux.xyz);
}

// Film positions to points at a distance and back; w: area of a pixel there, times the density.
kernel void project_back(const Frame frame, const uint count, const global float4* films, global float4* result) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const float2 film = films[i].xy;
  const float distance = films[i].z, step = 0.25f;
  const Ray ray = camera_ray(&frame, film, 1u);
  const float3 point = ray.origin.xyz + distance * ray.direction.xyz;
  const CameraProjection seen = camera_project(&frame, point);
  // Neighbouring rays' points on the plane across the ray, half a pixel apart.
  float3 corner[4];
  for (uint k = 0u; k < 4u; ++k) {
    const float2 offset = (float2)(k & 1u ? step : -step, k & 2u ? step : -step);
    const Ray side = camera_ray(&frame, film + offset, 1u);
    const float t = dot(point - side.origin.xyz, ray.direction.xyz) / dot(side.direction.xyz, ray.direction.xyz);
    corner[k] = side.origin.xyz + t * side.direction.xyz - point;
  }
  const float area = 0.5f * length(cross(corner[3] - corner[0], corner[2] - corner[1])) / (4.0f * step * step);
  result[i] = (float4)(seen.film, seen.distance, seen.density * area);
}
