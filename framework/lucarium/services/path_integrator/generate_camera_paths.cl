// SPDX-License-Identifier: Apache-2.0
// Starts the paths of a batch at the camera.
#include "lucarium/camera.clh"
#include "lucarium/services/path_integrator/path_state.clh"

__kernel void generate_camera_paths(Frame frame, PathSettings settings, PathBatch batch,
                                    LUCARIUM_RAY_ENDS_PARAMETER(ends) __global Ray* restrict rays,
                                    __global uint* restrict queue, __global uint* restrict active,
                                    __global float4* restrict path_throughput, __global PathState* restrict path_state,
                                    __global uint* restrict path_side, __global float4* restrict path_radiance) {
  const uint path = get_global_id(0);
  const uint paths = batch.pixel_count * batch.sample_count;
  if (path == 0) active[0] = paths;
  if (path >= paths) return;
  const Sampler sampler = make_path_sampler(settings, batch, path);
  const CameraSample u = sample_camera_dimensions(&sampler);
  const uint pixel = batch.first_pixel + path % batch.pixel_count;
  rays[path] = primary_ray(&frame, pixel % frame.width, pixel / frame.width, sampler.index, u.film,
                           path_ray_seed(settings, &sampler, LUCARIUM_NONE));
  LUCARIUM_STORE_RAY_ENDS(ends, path, no_ray_ends());
  queue[path] = path;
  path_throughput[path] = (float4)(1.0f, 1.0f, 1.0f, 0.0f);
  PathState state;
  state.scatterings = 0;
  state.segment = 0;
  state.medium = LUCARIUM_NONE;
  state.flags = path_with_carried(PATH_AFTER_DELTA, 1.0f);
  path_state[path] = state;
  path_side[path] = LUCARIUM_NONE;
  for (uint layer = 0; layer < LUCARIUM_PATH_LAYERS; ++layer) path_radiance[layer * paths + path] = (float4)(0.0f);
}
