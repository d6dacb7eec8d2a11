// SPDX-License-Identifier: Apache-2.0
// One vertex of every eye path: ideal reflection and refraction are followed, the first other surface is kept.
#include "lucarium/lights.clh"
#include "lucarium/medium.clh"
#include "lucarium/scene.clh"
#include "lucarium/services/gbuffer/gbuffer_sampler.clh"
#include "lucarium/services/gbuffer/keep_surface.clh"
#include "lucarium/shared/camera.h"
#include "lucarium/shared/path_settings.h"

// True when the path goes on along `next_ray`.
bool follow_hit(const Scene* scene, uint seed, uint sample_index, uint pixel, Hit hit, float3 direction,
                GBufferPoint* point, Ray* next_ray, RayEnds* next_ends) {
  const Surface surface = make_surface(scene, hit, direction, 0u);
  point->position.w += hit.distance;
  // While the path is followed, the medium of its ray waits where the view will be.
  const uint medium = medium_at(scene, &surface, as_uint(point->view.w));
  point->throughput.xyz *= medium_transmittance(scene, medium, hit.distance);
  point->emission.xyz += point->throughput.xyz * emitted_radiance(scene, &surface);
  const Bsdf bsdf = make_bsdf(scene, &surface, 0u);
  const uint events = (uint)point->throughput.w;
  const Sampler sampler = make_pixel_sampler(seed, pixel, sample_index);
  const LightChoiceSample u = sample_light_dimensions(&sampler, events);
  const DirectionSample v = sample_direction_dimensions(&sampler, events);
  const BsdfSample sample = sample_bsdf(&bsdf, u.lobe, v.direction);
#ifdef LUCARIUM_GBUFFER_FIRST_SURFACE
  keep_surface(scene, &surface, &bsdf, hit, medium, 1.0f, point);
  return false;
#endif
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

// Work-item i: ray i of the queue. Writes alive[i], and where it is 1 next_rays[i], next_ends[i] and next_queue[i].
__kernel void fill_gbuffer(LUCARIUM_SCENE_PARAMETERS Frame frame, uint sample_index, __global const Ray* restrict rays,
                           __global const Hit* restrict hits, __global const uint* restrict queue,
                           __global const uint* restrict active, __global GBufferPoint* restrict points,
                           LUCARIUM_RAY_ENDS_PARAMETER(next_ends) __global Ray* restrict next_rays,
                           __global uint* restrict next_queue, __global uint* restrict alive) {
  const uint i = get_global_id(0);
  if (i >= active[0]) return;
  LUCARIUM_SCENE_BIND(scene);
  const uint pixel = queue[i];
  const Hit hit = hits[i];
  const float3 direction = rays[i].direction.xyz;
  GBufferPoint point = points[pixel];
  bool goes_on = false;
  Ray next_ray = rays[i];
  RayEnds ends = no_ray_ends();
  if (hit.triangle != LUCARIUM_NO_HIT)
    goes_on = follow_hit(&scene, frame.seed, sample_index, pixel, hit, direction, &point, &next_ray, &ends);
  else if (scene.scene_info->environment_light != LUCARIUM_NONE)
    point.emission.xyz += point.throughput.xyz * environment_radiance(&scene, direction);
  if (!goes_on && point.state != LUCARIUM_GBUFFER_SURFACE) point.view.w = 0.0f;
  points[pixel] = point;
  alive[i] = goes_on;
  next_rays[i] = next_ray;
  LUCARIUM_STORE_RAY_ENDS(next_ends, i, ends);
  next_queue[i] = pixel;
}
