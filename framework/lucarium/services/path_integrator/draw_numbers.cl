// SPDX-License-Identifier: Apache-2.0
// The random numbers of every active path's vertex, and what depends on them alone, of eight paths at once: chains of
// dependent operations, which took a third of the time of shading.
#include "lucarium/services/path_integrator/path_state.clh"

// Work-item i: entries 8 i to 8 i + 7 of the queue; of paths beyond its end it repeats the last. All active paths have
// visited equally many vertices.
__kernel void draw_vertex_numbers(PathSettings settings, PathBatch batch, __global const uint* restrict queue,
                                  __global const uint* restrict active, __global const PathState* restrict path_state,
                                  __global float* restrict numbers) {
  const uint i = get_global_id(0), count = active[0];
  if (8u * i >= count) return;
  const uint8 places = min(8u * i + (uint8)(0u, 1u, 2u, 3u, 4u, 5u, 6u, 7u), count - 1u);
  const uint8 paths = (uint8)(queue[places.s0], queue[places.s1], queue[places.s2], queue[places.s3], queue[places.s4],
                              queue[places.s5], queue[places.s6], queue[places.s7]);
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
  const uint mode = path_sampler_mode(settings);

  float8 light[4], direction[4], cosine[3];
  sampler_blocks(seeds, index, mode, 1u + 2u * vertex, light);
  sampler_blocks(seeds, index, mode, 2u + 2u * vertex, direction);
  sample_cosine_hemispheres(direction[0], direction[1], &cosine[0], &cosine[1], &cosine[2]);
  // path_ray_seed()
  uint8 shadow_seed = (uint8)(LUCARIUM_SEED_OPAQUE), next_seed = (uint8)(LUCARIUM_SEED_OPAQUE);
  if (!(settings.flags & LUCARIUM_PATH_OPAQUE_BLEND)) {
    shadow_seed = hash_uints(seeds + hash_uints(index + hash_uint(2u * vertex))) | 1u;
    next_seed = hash_uints(seeds + hash_uints(index + hash_uint(2u * vertex + 1u))) | 1u;
  }
  __global float* rows = numbers + LUCARIUM_PATH_NUMBER_ROWS * 8u * (size_t)i;
  vstore8(light[0], 0, rows);
  vstore8(light[1], 1, rows);
  vstore8(light[2], 2, rows);
  vstore8(light[3], 3, rows);
  vstore8(direction[0], 4, rows);
  vstore8(direction[1], 5, rows);
  vstore8(direction[2], 6, rows);
  vstore8(cosine[0], 7, rows);
  vstore8(cosine[1], 8, rows);
  vstore8(cosine[2], 9, rows);
  vstore8(as_float8(shadow_seed), 10, rows);
  vstore8(as_float8(next_seed), 11, rows);
}
