// SPDX-License-Identifier: Apache-2.0
// Walks from a list of points, all of them a step at a time. A place holds a point and its walk; when the walk is
// caught the point's next one begins there, and points that are done leave their places to others.
#include "lucarium/prefetch.clh"
#include "lucarium/services/interior_surfaces/walk.clh"
#include "lucarium/shared/interior_point.h"
#include "lucarium/surface_point.clh"

#define WALK_STREAM 0x6d657870u
#define WALK_SERIES 0x3ffffu  // points so far apart in the list share random numbers

// What is at a place: the point, and which step of which walk its ray is.
#define STATE(point, walk, step) ((uint2)(point, (walk) << 16 | (step)))
#define STATE_POINT(state) ((state).x)
#define STATE_WALK(state) ((state).y >> 16)
#define STATE_STEP(state) ((state).y & 0xffffu)

uint2 state_at(uint place, uint staying, uint first, __global const uint* list, __global const uint2* next_states) {
  return place < staying ? next_states[list[place]] : STATE(first + place - staying, 0u, 0u);
}

// Aims the rays of `staying` points, from the places that `list` names, and of `coming` ones from number `first` on;
// those that are known to be open get none. behind: first steps lead to the side behind the point.
__kernel void aim_point_walks(LUCARIUM_SCENE_PARAMETERS __global const InteriorPoint* restrict points, uint behind,
                              uint staying, uint first, uint coming, __global const uint* restrict list,
                              __global const uint2* restrict next_states, __global const Ray* restrict next_rays,
                              LUCARIUM_CONST_RAY_ENDS_PARAMETER(next_ends) __global const uchar* restrict open,
                              __global uint2* restrict states,
                              LUCARIUM_RAY_ENDS_PARAMETER(ends) __global Ray* restrict rays,
                              __global uint* restrict total) {
  const uint k = get_global_id(0), count = staying + coming;
  if (k == 0u) total[0] = count;
  if (k >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  const uint far = k + 16u, near = k + 8u;  // what later work-items will need (prefetch.clh)
  if (far < count) {
    const uint point = STATE_POINT(state_at(far, staying, first, list, next_states));
    LUCARIUM_PREFETCH(scene.scene_triangles + (points[point].triangle & INTERIOR_TRIANGLE));
  }
  if (near < count) {
    const uint point = STATE_POINT(state_at(near, staying, first, list, next_states));
    prefetch_corners(&scene, points[point].triangle & INTERIOR_TRIANGLE);
  }
  const uint2 state = state_at(k, staying, first, list, next_states);
  states[k] = state;
  if (STATE_STEP(state) > 0u) {
    rays[k] = next_rays[list[k]];
    LUCARIUM_STORE_RAY_ENDS(ends, k, next_ends[list[k]]);
    return;
  }
  rays[k] = inactive_ray();
  if (open[STATE_POINT(state)]) return;
  const InteriorPoint point = points[STATE_POINT(state)];
  const Surface surface =
      surface_on_side(&scene, point.triangle & INTERIOR_TRIANGLE, point.u, point.v, !(point.triangle & INTERIOR_BACK));
  const uint random = hash_uint3(STATE_POINT(state) & WALK_SERIES, WALK_STREAM + 1u + behind, STATE_WALK(state));
  const Ray ray = random_walk_ray(&surface, behind ? -surface.n_g : surface.n_g, random);
  rays[k] = ray;
  LUCARIUM_STORE_RAY_ENDS(ends, k, ray_ends(&surface, ray.direction.xyz));
}

// What the steps have met: open[i] becomes 1 where a walk escapes; stays[k] says who goes on, with which step.
__kernel void judge_point_walks(LUCARIUM_SCENE_PARAMETERS __global const uint* restrict total, uint walks, uint steps,
                                float contact, __global const Hit* restrict hits, __global const Ray* restrict rays,
                                __global const uint2* restrict states, __global uint2* restrict next_states,
                                LUCARIUM_RAY_ENDS_PARAMETER(next_ends) __global Ray* restrict next_rays,
                                __global uint* restrict stays, __global uchar* restrict open) {
  const uint k = get_global_id(0), count = total[0];
  if (k >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  prefetch_corners_ahead(&scene, hits, k, count);
  stays[k] = 0u;
  const Ray ray = rays[k];
  if (!ray_is_active(ray)) return;
  const Hit hit = hits[k];
  const uint2 state = states[k];
  const uint step = STATE_STEP(state);
  int what = WALK_ESCAPED;
  if (hit.triangle != LUCARIUM_NO_HIT) {
    const Surface end = make_surface(&scene, hit, ray.direction.xyz, 0u);
    what = walk_end(&scene, &end, ray, hit, contact, step + 1u == steps);
    if (what == WALK_GOES_ON) {
      const Ray next = next_walk_ray(&end, ray, step);
      next_rays[k] = next;
      LUCARIUM_STORE_RAY_ENDS(next_ends, k, ray_ends(&end, next.direction.xyz));
    }
  }
  if (what == WALK_ESCAPED) {
    open[STATE_POINT(state)] = 1;
    return;
  }
  const uint walk = STATE_WALK(state) + (what == WALK_CAUGHT);
  stays[k] = walk < walks;
  next_states[k] = STATE(STATE_POINT(state), walk, what == WALK_CAUGHT ? 0u : step + 1u);
}
