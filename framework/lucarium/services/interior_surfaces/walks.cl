// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/interior_surfaces/walk.clh"
#include "lucarium/shared/interior_point.h"
#include "lucarium/surface_point.clh"

#define WALK_STREAM 0x6d657870u

Ray walk_ray_of(const Surface* surface, float3 n, uint random) {
  return walk_ray(surface, n, (float2)(uint_to_unit(random), uint_to_unit(hash_uint(random))), random);
}

// The first ray of walk `number` of every point from which none has escaped yet. behind: from the side behind it.
__kernel void begin_point_walks(LUCARIUM_SCENE_PARAMETERS __global const InteriorPoint* restrict points, uint count,
                                uint behind, uint number, __global const uchar* restrict escaped,
                                LUCARIUM_RAY_ENDS_PARAMETER(ends) __global Ray* restrict rays) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  rays[i] = inactive_ray();
  if (escaped[i]) return;
  LUCARIUM_SCENE_BIND(scene);
  const InteriorPoint point = points[i];
  const Surface surface =
      surface_on_side(&scene, point.triangle & INTERIOR_TRIANGLE, point.u, point.v, !(point.triangle & INTERIOR_BACK));
  const Ray ray =
      walk_ray_of(&surface, behind ? -surface.n_g : surface.n_g, hash_uint3(i, WALK_STREAM + 1u + behind, number));
  rays[i] = ray;
  LUCARIUM_STORE_RAY_ENDS(ends, i, ray_ends(&surface, ray.direction.xyz));
}

// Step `number` of the walks: those that go on get their next ray, others an inactive one, and those that escape set
// escaped[i]. last: who has come so far has escaped too.
__kernel void step_walks(LUCARIUM_SCENE_PARAMETERS __global const uint* restrict walks, uint number, uint last,
                         float contact, __global const Hit* restrict hits,
                         LUCARIUM_RAY_ENDS_PARAMETER(ends) __global Ray* restrict rays,
                         __global uchar* restrict escaped) {
  const uint i = get_global_id(0);
  if (i >= walks[0] || !ray_is_active(rays[i])) return;
  const Ray ray = rays[i];
  const Hit hit = hits[i];
  rays[i] = inactive_ray();
  if (hit.triangle == LUCARIUM_NO_HIT) {
    escaped[i] = 1;
    return;
  }
  LUCARIUM_SCENE_BIND(scene);
  const Surface end = make_surface(&scene, hit, ray.direction.xyz, 0u);
  const int what = walk_end(&scene, &end, ray, hit, contact);
  if (what == WALK_ESCAPED || (what == WALK_GOES_ON && last))
    escaped[i] = 1;
  else if (what == WALK_GOES_ON) {
    const Ray next = walk_ray_of(&end, end.n_g, hash_uint2(as_uint(ray.origin.w), number));
    rays[i] = next;
    LUCARIUM_STORE_RAY_ENDS(ends, i, ray_ends(&end, next.direction.xyz));
  }
}
