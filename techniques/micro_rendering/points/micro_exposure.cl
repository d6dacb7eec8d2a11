// SPDX-License-Identifier: Apache-2.0
// Which sides of points anything sees, see point_exposure.h.
#include "lucarium/random.clh"
#include "lucarium/warp.clh"
#include "micro_rendering/gather/micro_surface.clh"

#define MICRO_EXPOSURE_STREAM 0x6d657870u

// A ray from `surface` on the side of unit vector n; directions in proportion to their cosine.
Ray exposure_ray(const Surface* surface, float3 n, uint random) {
  const float2 u = (float2)(uint_to_unit(random), uint_to_unit(hash_uint(random)));
  const Basis basis = make_basis(n);
  return make_ray(surface, to_world(&basis, sample_cosine_hemisphere(u)), make_ray_seed(random));
}

// The first ray of walk `number` of every leaf from whose side (MICRO_SEEN_FRONT or MICRO_SEEN_BACK) none has escaped
// yet.
__kernel void mr_begin_walks(LUCARIUM_SCENE_PARAMETERS __global const MicroLeaf* restrict leaves, const uint count,
                             const uint side, const uint number, __global const uchar* restrict escaped,
                             __global Ray* restrict rays) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  rays[i] = inactive_ray();
  if (escaped[i]) return;
  LUCARIUM_SCENE_BIND(scene);
  const Surface surface = leaf_surface(&scene, leaves[i]);
  const float3 n = side == MICRO_SEEN_FRONT ? surface.n_g : -surface.n_g;
  rays[i] = exposure_ray(&surface, n, hash_uint3(i, MICRO_EXPOSURE_STREAM + side, number));
}

// What becomes of a walk where it ends: WALK_CAUGHT in a solid or between solids that touch, WALK_ESCAPED, or WALK_ON.
#define WALK_CAUGHT 0
#define WALK_ESCAPED 1
#define WALK_ON 2
int walk_end(const Scene* scene, const Surface* end, Ray ray, Hit hit, float contact) {
  const uint flags = scene->scene_materials[end->material].flags;
  if (flags & LUCARIUM_MATERIAL_TRANSMISSIVE) return WALK_ESCAPED;
  if (shows_both_sides(flags)) return WALK_ON;
  if (!(end->flags & LUCARIUM_SURFACE_FRONT)) return WALK_CAUGHT;
  return hit.distance * -dot(end->n_g, ray.direction.xyz) > contact ? WALK_ON : WALK_CAUGHT;
}

// Step `number` of the walks. `last`: who comes so far has escaped too.
__kernel void mr_walk(LUCARIUM_SCENE_PARAMETERS const uint count, const uint number, const uint last,
                      const float contact, __global const Hit* restrict hits, __global Ray* restrict rays,
                      __global uchar* restrict escaped) {
  const uint i = get_global_id(0);
  if (i >= count || !ray_is_active(rays[i])) return;
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
  if (what == WALK_ESCAPED || (what == WALK_ON && last))
    escaped[i] = 1;
  else if (what == WALK_ON)
    rays[i] = exposure_ray(&end, end.n_g, hash_uint2(as_uint(ray.origin.w), number));
}
