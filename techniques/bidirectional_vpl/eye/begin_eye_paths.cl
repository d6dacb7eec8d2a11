// SPDX-License-Identifier: Apache-2.0
// Starts one camera path per pixel.
#include "bidirectional_vpl/eye/eye_path.clh"
#include "lucarium/camera.clh"

__kernel void begin_eye_paths(Frame frame, const BidirectionalSettings settings, uint sample_index,
                              LUCARIUM_RAY_ENDS_PARAMETER(ends) __global Ray* restrict rays,
                              __global uint* restrict queue, __global uint* restrict active,
                              __global EyePathState* restrict states, __global float* restrict eye_mis,
#ifdef EYE_CACHES
                              __global const float4* restrict reused,
#endif
                              uint slice_base) {
  const uint pixel = slice_base + (uint)get_global_id(0);
  if (pixel == 0u) active[0] = settings.pixels;
  if (pixel >= settings.pixels) return;
  const Sampler sampler = make_pixel_sampler(frame.seed, pixel, sample_index);
  const CameraSample u = sample_camera_dimensions(&sampler);
  const Ray ray = primary_ray(&frame, pixel % frame.width, pixel / frame.width, sample_index, u.film,
                              eye_ray_seed(&sampler, LUCARIUM_NONE));
  rays[pixel] = ray;
  LUCARIUM_STORE_RAY_ENDS(ends, pixel, no_ray_ends());
  queue[pixel] = pixel;
  EyePathState state;
  state.throughput = (float4)(1.0f, 1.0f, 1.0f, camera_ray_density(&frame, ray.direction.xyz));
  state.scatterings = state.segment = 0u;
  state.medium = LUCARIUM_NONE;
  state.flags = EYE_PATH_AFTER_DELTA | EYE_PATH_CHAIN;
  if (film_plane(&frame).orthographic) state.flags |= EYE_PATH_PARALLEL;
#ifdef EYE_CACHES
  if (reused[pixel].w > 0.0f) state.flags |= EYE_PATH_CACHED;
#endif
  state.cosine = 1.0f;
  state.carried = path_mis_power(settings.splat_samples);
  state.bundle = state.left = LUCARIUM_NONE;
  state.rest = 1.0f;
  state.gain = 1.0f;
  state.pad0 = state.pad1 = 0u;
  states[pixel] = state;
  for (uint m = 0u; m < LIGHT_VERTICES; ++m) eye_mis[m * settings.pixels + pixel] = 0.0f;
}
