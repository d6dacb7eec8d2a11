// SPDX-License-Identifier: Apache-2.0
// The random numbers of every active path's vertex: drawn in shading they took a third of its time.
#include "lucarium/services/path_integrator/path_state.clh"

// Work-item i: places 8 i to 8 i + 7 of the queue. All active paths have visited equally many vertices.
__kernel void draw_vertex_numbers(PathSettings settings, PathBatch batch, __global const uint* restrict queue,
                                  __global const uint* restrict active, __global const PathState* restrict path_state,
                                  __global float* restrict numbers) {
  const uint i = get_global_id(0), count = active[0];
  if (8u * i >= count) return;
  const uint8 paths = queued_paths8(queue, i, count);
  const uint vertex = path_state[paths.s0].segment;
  // Paths scatter for the last time at the same vertex, except for those that met mirrors first.
  if (vertex >= settings.max_scatterings && path_ends_here(settings, path_state[paths.s0]) &&
      path_ends_here(settings, path_state[paths.s1]) && path_ends_here(settings, path_state[paths.s2]) &&
      path_ends_here(settings, path_state[paths.s3]) && path_ends_here(settings, path_state[paths.s4]) &&
      path_ends_here(settings, path_state[paths.s5]) && path_ends_here(settings, path_state[paths.s6]) &&
      path_ends_here(settings, path_state[paths.s7]))
    return;
  // make_path_sampler()
  const uint8 sample = batch.first_sample + paths / batch.pixel_count;
  const uint8 pixel = batch.first_pixel + paths % batch.pixel_count;
  const uint8 replicate = sample % settings.replicates, index = sample / settings.replicates;
  const uint8 seeds = hash_uints(pixel + hash_uints(replicate + hash_uint(batch.seed)));
  draw_vertex_numbers8(seeds, index, path_sampler_mode(settings), vertex, settings.flags & LUCARIUM_PATH_OPAQUE_BLEND,
                       i, numbers);
}
