// SPDX-License-Identifier: Apache-2.0
// What camera rays meet, from a rasterized picture of triangles.
#include "lucarium/scene.clh"
#include "lucarium/shared/layered_raster.h"
#include "lucarium/surface.clh"
#include "voxel_abuffer/structure/fragment_point.clh"

#define PRIMARY_ELSEWHERE -1.0f  // distance of a ray that must be traced

// How far off a pixel's centre a ray may pass, by rounding [pixels].
#define PRIMARY_TOLERANCE 0.01f

// The pixel through whose centre a ray leaves the eye; LUCARIUM_NONE: it is no such ray.
static uint primary_pixel(const LayeredView* view, float4 eye, Ray ray) {
  const float3 d = ray.direction.xyz;
  const float w = dot(view->row_w.xyz, d);
  if (any(ray.origin.xyz != eye.xyz) || !(ray.direction.w > 0.0f) || !(w > 0.0f)) return LUCARIUM_NONE;
  const float2 at = (float2)(dot(view->row_x.xyz, d), dot(view->row_y.xyz, d)) / w, pixel = floor(at);
  if (any(fabs(at - pixel - 0.5f) > PRIMARY_TOLERANCE) || any(pixel < 0.0f)) return LUCARIUM_NONE;
  const uint x = (uint)pixel.x, y = (uint)pixel.y;
  return x < view->width && y < view->height ? y * view->width + x : LUCARIUM_NONE;
}

// Where a ray meets a triangle that its pixel shows: in the triangle's plane, between the depths of its corners.
static Hit primary_hit(const Scene* scene, const LayeredView* view, uint triangle, float depth, Ray ray) {
  const Triangle t = scene->scene_triangles[triangle];
  const float3 a = scene->scene_vertices[t.v0].position.xyz, b = scene->scene_vertices[t.v1].position.xyz,
               c = scene->scene_vertices[t.v2].position.xyz;
  const float3 o = ray.origin.xyz, d = ray.direction.xyz, n = cross(b - a, c - a);
  const float rate = 1.0f / dot(view->row_w.xyz, d);
  const float3 depths =
      ((float3)(dot(view->row_w.xyz, a), dot(view->row_w.xyz, b), dot(view->row_w.xyz, c)) + view->row_w.w) * rate;
  const float nearest = fmin(depths.x, fmin(depths.y, depths.z)), farthest = fmax(depths.x, fmax(depths.y, depths.z));
  const float plane = dot(a - o, n) / dot(d, n);
  const float distance = fmax(isfinite(plane) ? clamp(plane, nearest, farthest) : depth * rate, 0.0f);
  const float2 uv = abuffer_clamped_barycentrics(a, b, c, o + d * distance);
  const Hit hit = {distance, triangle, uv.x, uv.y};
  return hit;
}

// seen: the hit of a ray whose pixel knows it, else PRIMARY_ELSEWHERE as distance. others: the rays that are left, at
// their places; the first kind inactive.
__kernel void look_up_primary(LUCARIUM_SCENE_PARAMETERS __global const LayeredView* restrict views,
                              __global const float4* restrict eye, __global const uint* restrict triangles,
                              __global const float* restrict depths, __global const uint* restrict counter,
                              uint counter_index, uint capacity, __global const Ray* restrict rays,
                              __global Ray* restrict others, __global Hit* restrict seen) {
  const uint i = get_global_id(0);
  if (i >= min(counter[counter_index], capacity)) return;
  LUCARIUM_SCENE_BIND(scene);
  const LayeredView view = views[0];
  Ray ray = rays[i];
  Hit hit = {PRIMARY_ELSEWHERE, LUCARIUM_NO_HIT, 0.0f, 0.0f};
  const uint pixel = primary_pixel(&view, eye[0], ray);
  if (pixel != LUCARIUM_NONE) {
    const uint shown = triangles[pixel];
    if (shown == LUCARIUM_NONE) {
      hit.distance = INFINITY;
    } else {
      const Hit there = primary_hit(&scene, &view, shown & ~LAYERED_AWAY, depths[pixel], ray);
      if (alpha_passes(&scene, there.triangle, there.u, there.v, as_uint(ray.origin.w))) hit = there;
    }
  }
  seen[i] = hit;
  if (hit.distance != PRIMARY_ELSEWHERE) ray.direction.w = -1.0f;
  others[i] = ray;
}

__kernel void take_primary(__global const uint* restrict counter, uint counter_index, uint capacity,
                           __global const Hit* restrict seen, __global Hit* restrict hits) {
  const uint i = get_global_id(0);
  if (i >= min(counter[counter_index], capacity)) return;
  if (seen[i].distance != PRIMARY_ELSEWHERE) hits[i] = seen[i];
}
