// SPDX-License-Identifier: Apache-2.0
// Starts one eye path per pixel.
#include "lucarium/camera.clh"
#include "lucarium/services/gbuffer/gbuffer_sampler.clh"
#include "lucarium/shared/gbuffer.h"
#include "lucarium/shared/scene_types.h"

__kernel void generate_gbuffer_rays(Frame frame, uint sample_index, __global GBufferPoint* restrict points,
                                    LUCARIUM_RAY_ENDS_PARAMETER(ends) __global Ray* restrict rays,
                                    __global uint* restrict queue, __global uint* restrict active) {
  const uint pixel = get_global_id(0);
  if (pixel == 0) active[0] = frame.width * frame.height;
  if (pixel >= frame.width * frame.height) return;
  const Sampler sampler = make_pixel_sampler(frame.seed, pixel, sample_index);
  const CameraSample u = sample_camera_dimensions(&sampler);
  rays[pixel] = primary_ray(&frame, pixel % frame.width, pixel / frame.width, sample_index, u.film,
                            make_ray_seed(hash_uint3(sampler.seed, sample_index, LUCARIUM_NONE)));
  LUCARIUM_STORE_RAY_ENDS(ends, pixel, no_ray_ends());
  queue[pixel] = pixel;
  GBufferPoint point;
  point.position = point.normal = point.shading = point.view = point.emission = point.albedo = (float4)(0.0f);
  point.throughput = (float4)(1.0f, 1.0f, 1.0f, 0.0f);
  point.view.w = as_float(LUCARIUM_NONE);  // the medium, see fill_gbuffer
  point.u = point.v = 0.0f;
  point.triangle = LUCARIUM_NONE;
  point.state = LUCARIUM_GBUFFER_MISS;
  points[pixel] = point;
}
