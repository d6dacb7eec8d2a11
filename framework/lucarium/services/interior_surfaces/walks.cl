// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/interior_surfaces/walk.clh"

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
  const int what = walk_end(&scene, &end, ray, hit, contact, last);
  if (what == WALK_ESCAPED)
    escaped[i] = 1;
  else if (what == WALK_GOES_ON) {
    const Ray next = next_walk_ray(&end, ray, number);
    rays[i] = next;
    LUCARIUM_STORE_RAY_ENDS(ends, i, ray_ends(&end, next.direction.xyz));
  }
}
