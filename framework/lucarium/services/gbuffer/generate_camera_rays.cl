// SPDX-License-Identifier: Apache-2.0
// Starts one eye path per pixel.
#include "lucarium/camera.clh"
#include "lucarium/ray_ends.clh"
#include "lucarium/scene.clh"
#include "lucarium/services/gbuffer/gbuffer_sampler.clh"

// Work-item i: rays[i], through pixel i. active[0]: their number.
__kernel LUCARIUM_FLATTEN void generate_camera_rays(Frame frame, uint sample_index,
                                                    LUCARIUM_RAY_ENDS_PARAMETER(ends) __global Ray* restrict rays,
                                                    __global uint* restrict active) {
  const uint pixel = get_global_id(0);
  if (pixel == 0) active[0] = frame.width * frame.height;
  if (pixel >= frame.width * frame.height) return;
  const Sampler sampler = make_pixel_sampler(frame.seed, pixel, sample_index);
  const CameraSample u = sample_camera_dimensions(&sampler);
  rays[pixel] = primary_ray(&frame, pixel % frame.width, pixel / frame.width, sample_index, u.film,
                            make_ray_seed(hash_uint3(sampler.seed, sample_index, LUCARIUM_NONE)));
  LUCARIUM_STORE_RAY_ENDS(ends, pixel, no_ray_ends());
}
