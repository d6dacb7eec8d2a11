// SPDX-License-Identifier: Apache-2.0
// What camera paths meet along a bundle, from its stored fragments instead of by rays (Tokuyoshi and Ogaki 2012,
// section 3.2: the visible fragment by linear search). The point of a path is found among the fragments of its pixel;
// the next fragment along the ray, of either facing, is what it sees. The point that is met lies on the ray and in that
// fragment's triangle, clamped to it; the ray lies up to a pixel beside the one that was rasterized. With
// BUNDLES_EXACT a pixel lists every triangle that it touches, and the ray itself is tested against them.
#include "bidirectional_vpl/base/meet_plane.clh"
#include "bidirectional_vpl/bundles/eight_look_ups.clh"
#include "lucarium/scene.clh"
#include "lucarium/services/layered_raster/fragment_list.clh"
#include "lucarium/surface.clh"

#define LOOK_UP_SLACK 1e-6f  // of barycentric weights: rays do not pass between triangles

Hit no_hit(void) {
  const Hit miss = {INFINITY, LUCARIUM_NO_HIT, 0.0f, 0.0f};
  return miss;
}

#ifdef BUNDLES_EXACT

// The nearest triangle of the pixel's list that the ray meets; BLEND and MASK as every ray decides them.
LUCARIUM_JOIN Hit look_up(const Scene* scene, const FragmentList* list, Ray ray, uint left) {
  Hit best = no_hit();
  uint first, end;
  if (!list_pixel(list, convert_int2_rtn(list_place(list, ray.origin.xyz)), &first, &end)) return best;
  for (uint i = first; i < end; ++i) {
    const uint triangle = list->fragments[i].triangle & ~LAYERED_AWAY;
    float3 w;
    if (!meet_plane(scene, triangle, ray.origin.xyz, ray.direction.xyz, &w)) continue;
    if (w.x < -LOOK_UP_SLACK || w.y < -LOOK_UP_SLACK || w.x + w.y > 1.0f + LOOK_UP_SLACK) continue;
    if (!(w.z > 0.0f && w.z < best.distance)) continue;
    if (!alpha_passes(scene, triangle, w.x, w.y, as_uint(ray.origin.w))) continue;
    const Hit hit = {w.z, triangle, clamp(w.x, 0.0f, 1.0f), clamp(w.y, 0.0f, 1.0f - clamp(w.x, 0.0f, 1.0f))};
    best = hit;
  }
  return best;
}

#else

// `left`: the triangle that the ray leaves.
LUCARIUM_JOIN Hit look_up(const Scene* scene, const FragmentList* list, Ray ray, uint left) {
  const float3 origin = ray.origin.xyz, direction = ray.direction.xyz;
  const Triangle t = scene->scene_triangles[left];
  const float3 front =
      geometric_normal(scene->scene_vertices[t.v0].position.xyz, scene->scene_vertices[t.v1].position.xyz,
                       scene->scene_vertices[t.v2].position.xyz, direction);
  const bool on_front = dot(front, direction) > 0.0f;
  const ListedPoint point = listed_point(list, origin, left, on_front ? front : -front, on_front);
  const SeenFragment seen = seen_fragment(list, &point, true);
  if (seen.fragment == LUCARIUM_NONE) return no_hit();
  // The ray's point in the plane of what it sees, clamped to the triangle. It lies before the origin at times, by less
  // than the surface drops over a pixel.
  const uint triangle = list->fragments[seen.fragment].triangle & ~LAYERED_AWAY;
  float2 w = fragment_weights(scene, list, triangle, point.place);
  w.y = fmin(w.y, 1.0f - w.x);
  const Triangle other = scene->scene_triangles[triangle];
  const float3 met =
      interpolate3(scene->scene_vertices[other.v0].position.xyz, scene->scene_vertices[other.v1].position.xyz,
                   scene->scene_vertices[other.v2].position.xyz, w.x, w.y);
  const float nearest = 1e-3f / length(list->view->row_x.xyz);
  const Hit hit = {fmax(dot(met - origin, direction), nearest), triangle, w.x, w.y};
  return hit;
}

#define LOOK_UP_EIGHT

// Rays order[first] to order[first + 7]. False, and nothing done, where a triangle is so large or small that its normal
// needs care.
LUCARIUM_JOIN bool look_up8(const Scene* scene, const FragmentList* list, uint first, __global const uint* order,
                            __global const Ray* rays, __global const uint* left, __global Hit* hits) {
  const uint8 ray = vload8(0, order + first), triangle = LIST_OF_EIGHT(uint8, left, ray);
  const uint stride = sizeof(Ray) / sizeof(float4);
  const Fields8 begin = gather_fields8((const __global float4*)rays, stride, ray);
  const Fields8 along = gather_fields8((const __global float4*)rays + 1, stride, ray);
  const Vectors8 origin = {begin.x, begin.y, begin.z}, direction = {along.x, along.y, along.z};
  const Corners8 t = corners8(scene, triangle);
  const Vectors8 area_normal = cross8(minus8(t.b, t.a), minus8(t.c, t.a));
  const float8 area2 = dot8(area_normal, area_normal);
  if (lane_bits8((area2 >= 1e-28f) & (area2 <= 1e28f)) != 255u) return false;
  const ListedPoints8 points = listed_points8(list->view, origin, direction, area_normal, area2);
  const uint8 seen = seen_triangles8(list, &points, triangle);
  Fields8 met = seen_hits8(scene, list->view, seen, origin, direction, points.x, points.y);
  turn_squares(&met.x, &met.y, &met.z, &met.w);
  __global float4* out = (__global float4*)hits;
  out[ray.s0] = met.x.lo;
  out[ray.s1] = met.y.lo;
  out[ray.s2] = met.z.lo;
  out[ray.s3] = met.w.lo;
  out[ray.s4] = met.x.hi;
  out[ray.s5] = met.y.hi;
  out[ray.s6] = met.z.hi;
  out[ray.s7] = met.w.hi;
  return true;
}

#endif

// The rays order[starts[number]] to order[starts[number + 1]], `chunk` to a work-item. The bundle begins at start_base
// of pixel_start and fragment_base of fragments.
__kernel void look_up_bundle(LUCARIUM_SCENE_PARAMETERS uint number, uint chunk, uint start_base, uint fragment_base,
                             __global const uint* restrict starts, __global const uint* restrict order,
                             __global const LayeredView* restrict views, __global const uint* restrict pixel_start,
                             __global const LayeredFragment* restrict fragments, __global const Ray* restrict rays,
                             __global const uint* restrict left, __global Hit* restrict hits, uint slice_base) {
  const uint first = starts[number] + chunk * (slice_base + (uint)get_global_id(0));
  const uint end = min(first + chunk, starts[number + 1u]);
  if (first >= end) return;
  LUCARIUM_SCENE_BIND(scene);
  const FragmentList list = {views + number, pixel_start + start_base, fragments + fragment_base};
  for (uint k = first; k < end; k += 8u) {
    const uint stop = min(k + 8u, end);
#ifdef LOOK_UP_EIGHT
    if (stop == k + 8u && look_up8(&scene, &list, k, order, rays, left, hits)) continue;
#endif
    for (uint one = k; one < stop; ++one) {
      const uint i = order[one];
      hits[i] = look_up(&scene, &list, rays[i], left[i]);
    }
  }
}

// One work-item: how many fragments the bundle has.
__kernel void count_fragments(__global const LayeredView* restrict views, uint number,
                              __global const uint* restrict pixel_start, __global uint* restrict total) {
  total[0] = pixel_start[views[number].width * views[number].height];
}
