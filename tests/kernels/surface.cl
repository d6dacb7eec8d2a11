// SPDX-License-Identifier: Apache-2.0
#include "lucarium/camera.clh"
#include "lucarium/mis.clh"
#include "lucarium/surface_point.clh"

kernel void lookup_textures(LUCARIUM_SCENE_PARAMETERS const uint texture, const uint count, const global float2* uvs,
                            global float4* values) {
  LUCARIUM_SCENE_BIND(scene);
  const uint i = get_global_id(0);
  if (i < count) values[i] = lookup_texture(&scene, texture, uvs[i]);
}

// Per hit: position; n_g with the flags; n_s with the ray offset; uv0 and uv1; vertex colour; base colour; the origin
// of a ray that goes on along `direction`, and of one that turns back.
kernel void make_surfaces(LUCARIUM_SCENE_PARAMETERS const global Hit* hits, const float4 direction, const uint options,
                          const uint count, global float4* results) {
  LUCARIUM_SCENE_BIND(scene);
  const uint i = get_global_id(0);
  if (i >= count) return;
  const Surface surface = make_surface(&scene, hits[i], direction.xyz, options);
  global float4* result = results + 8 * i;
  result[0] = (float4)(surface.position, (float)surface.material);
  result[1] = (float4)(surface.n_g, (float)surface.flags);
  result[2] = (float4)(surface.n_s, surface.ray_offset);
  result[3] = (float4)(surface.uv0, surface.uv1);
  result[4] = surface.color;
  result[5] = base_color(&scene, &surface);
  result[6] = make_ray(&surface, direction.xyz, 7u).origin;
  result[7] = make_ray(&surface, -direction.xyz, 7u).origin;
}

// Both sides of stored points, front first: position and flags; n_g; n_s; view.
kernel void stand_on_points(LUCARIUM_SCENE_PARAMETERS const global Hit* points, const uint count,
                            global float4* results) {
  LUCARIUM_SCENE_BIND(scene);
  const uint i = get_global_id(0);
  if (i >= count) return;
  for (uint side = 0; side < 2; ++side) {
    const Surface surface = surface_on_side(&scene, points[i].triangle, points[i].u, points[i].v, side == 0);
    global float4* result = results + 8 * i + 4 * side;
    result[0] = (float4)(surface.position, (float)surface.flags);
    result[1] = (float4)(surface.n_g, 0.0f);
    result[2] = (float4)(surface.n_s, 0.0f);
    result[3] =
        (float4)(surface.view, ray_is_active(make_ray(&surface, surface.n_g, 7u)) && !ray_is_active(inactive_ray()));
  }
}

// How many of `count` seeds stop at a hit.
kernel void count_passes(LUCARIUM_SCENE_PARAMETERS const uint triangle, const float u, const float v,
                         const uint first_seed, const uint count, global uint* passes) {
  LUCARIUM_SCENE_BIND(scene);
  const uint i = get_global_id(0);
  if (i < count) passes[i] = alpha_passes(&scene, triangle, u, v, first_seed + i);
}

kernel void make_camera_rays(const Frame frame, const global uint4* samples, const global float2* jitters,
                             const uint count, global Ray* rays) {
  const uint i = get_global_id(0);
  if (i < count) rays[i] = primary_ray(&frame, samples[i].x, samples[i].y, samples[i].z, jitters[i], 5u);
}

// x: power heuristic, y: balance heuristic.
kernel void weigh(const global float2* densities, const uint count, global float2* weights) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const float2 d = densities[i];
  weights[i] = (float2)(power_heuristic(d.x, d.y), balance_heuristic(d.x, d.y));
}
