// SPDX-License-Identifier: Apache-2.0
// One vertex of every eye path: ideal reflection and refraction are followed, the first other surface is kept.
#include "lucarium/scene.clh"
#include "lucarium/services/gbuffer/eye_vertex.clh"
#include "lucarium/services/gbuffer/gbuffer_sampler.clh"
#include "lucarium/shared/camera.h"
#include "lucarium/shared/path_settings.h"

// True when the path goes on along `next_ray`.
LUCARIUM_FLATTEN bool follow_hit(const Scene* scene, uint seed, uint sample_index, uint pixel, Hit hit,
                                 float3 direction, GBufferPoint* point, Ray* next_ray, RayEnds* next_ends) {
  const Surface surface = make_surface(scene, hit, direction, 0u);
  const uint medium = arrive_at_surface(scene, &surface, hit, point);
  const Bsdf bsdf = make_bsdf(scene, &surface, 0u);
#ifdef LUCARIUM_GBUFFER_FIRST_SURFACE
  const bool keep = true;
#else
  const bool keep = !(bsdf.flags & LUCARIUM_BSDF_DELTA);  // no event to follow
#endif
  if (keep) {
    keep_surface(scene, &surface, &bsdf, hit, medium, 1.0f, point);
    return false;
  }
  const uint events = (uint)point->throughput.w;
  const Sampler sampler = make_pixel_sampler(seed, pixel, sample_index);
  const LightChoiceSample u = sample_light_dimensions(&sampler, events);
  const DirectionSample v = sample_direction_dimensions(&sampler, events);
  const BsdfSample sample = sample_bsdf(&bsdf, u.lobe, v.direction);
  if (!sample.delta) {
    float p_other = 1.0f;
    if (bsdf.flags & LUCARIUM_BSDF_DELTA_REFLECTION) p_other -= bsdf.p_reflect;
    if (bsdf.flags & LUCARIUM_BSDF_DELTA_TRANSMISSION) p_other -= bsdf.p_transmit;
    keep_surface(scene, &surface, &bsdf, hit, medium, p_other > 0.0f ? p_other : 1.0f, point);
    return false;
  }
  if (is_black(sample.weight) || events == LUCARIUM_PATH_EYE_DELTA_LIMIT) return false;
  point->throughput.xyz *= sample.weight;
  point->throughput.w += 1.0f;
  const uint next_medium = sample.transmitted ? medium_behind(scene, &surface, medium) : medium;
  point->view.w = as_float(next_medium);
  if (events >= LUCARIUM_PATH_EYE_ROULETTE_START) {  // as in shade_surface
    const float importance = max_component(point->throughput.xyz) * medium_squared_ior(scene, next_medium);
    const float survival = fmin(1.0f, importance);
    if (v.roulette >= survival) return false;
    point->throughput.xyz /= survival;
  }
  *next_ray =
      make_ray(&surface, sample.direction, make_ray_seed(hash_uint3(sampler.seed, sample_index, 2u * events + 1u)));
  *next_ends = ray_ends(&surface, sample.direction);
  return true;
}

// Work-item i: ray i of the queue; `first`: of camera rays, that of pixel i. Writes alive[i], and where it is 1
// next_rays[i], next_ends[i] and next_queue[i].
__kernel LUCARIUM_FLATTEN void fill_gbuffer(LUCARIUM_SCENE_PARAMETERS Frame frame, uint sample_index, uint first,
                                            __global const Ray* restrict rays, __global const Hit* restrict hits,
                                            __global const uint* restrict queue, __global const uint* restrict active,
                                            __global GBufferPoint* restrict points,
                                            LUCARIUM_RAY_ENDS_PARAMETER(next_ends) __global Ray* restrict next_rays,
                                            __global uint* restrict next_queue, __global uint* restrict alive) {
  const uint i = get_global_id(0);
  if (i >= active[0]) return;
  LUCARIUM_SCENE_BIND(scene);
  const uint pixel = first ? i : queue[i];
  const Hit hit = hits[i];
  const float3 direction = rays[i].direction.xyz;
  GBufferPoint point;
  if (first)
    point = begin_eye_path();
  else
    point = points[pixel];
  bool goes_on = false;
  if (hit.triangle != LUCARIUM_NO_HIT) {
    Ray next_ray;
    RayEnds ends;
    goes_on = follow_hit(&scene, frame.seed, sample_index, pixel, hit, direction, &point, &next_ray, &ends);
    if (goes_on) {
      next_rays[i] = next_ray;
      LUCARIUM_STORE_RAY_ENDS(next_ends, i, ends);
      next_queue[i] = pixel;
    }
  } else {
    leave_scene(&scene, direction, &point);
  }
  if (!goes_on && point.state != LUCARIUM_GBUFFER_SURFACE) point.view.w = 0.0f;
  points[pixel] = point;
  alive[i] = goes_on;
}
