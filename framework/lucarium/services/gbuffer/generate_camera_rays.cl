// SPDX-License-Identifier: Apache-2.0
// Starts one eye path per pixel.
#include "lucarium/camera.clh"
#include "lucarium/ray_ends.clh"
#include "lucarium/scene.clh"
#include "lucarium/services/gbuffer/gbuffer_sampler.clh"

// Work-item i: rays[8 i] to rays[8 i + 7], through the pixels of these numbers. active[0]: how many rays there are.
__kernel LUCARIUM_FLATTEN void generate_camera_rays(Frame frame, uint sample_index,
                                                    LUCARIUM_RAY_ENDS_PARAMETER(ends) __global Ray* restrict rays,
                                                    __global uint* restrict active) {
  const uint first = LUCARIUM_CAMERA_RAYS_EACH * get_global_id(0), count = frame.width * frame.height;
  if (first == 0) active[0] = count;
  if (first >= count) return;
  // Numbers of all, then rays one by one.
  const uint8 seeds = sampler_seeds(first, 0u, frame.seed);
  float8 film_x = (float8)(0.0f), film_y = film_x;
  if (frame.pixel_sampling == LUCARIUM_PIXEL_JITTER) sample_films(seeds, sample_index, &film_x, &film_y);
  const uint8 ray_seeds = hash_uints(seeds + hash_uint2(sample_index, LUCARIUM_NONE)) | 1u;  // make_ray_seed()
  float jitter_x[8], jitter_y[8];
  uint seed[8];
  vstore8(film_x, 0, jitter_x);
  vstore8(film_y, 0, jitter_y);
  vstore8(ray_seeds, 0, seed);
  uint x = first % frame.width, y = first / frame.width;
  const uint here = min(count - first, LUCARIUM_CAMERA_RAYS_EACH);
  for (uint k = 0u; k < here; ++k) {
    const float2 jitter = (float2)(jitter_x[k], jitter_y[k]);
    rays[first + k] = primary_ray(&frame, x, y, sample_index, jitter, seed[k]);
    LUCARIUM_STORE_RAY_ENDS(ends, first + k, no_ray_ends());
    if (++x == frame.width) x = 0u, ++y;
  }
}
