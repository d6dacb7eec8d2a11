// SPDX-License-Identifier: Apache-2.0
// The random numbers of every active camera path's vertex.
#include "bidirectional_vpl/eye/eye_path.clh"
#include "lucarium/eight/vertex_numbers.clh"

// Whether a path's next vertex scatters nothing: what emits there may count.
bool scatters_nothing(BidirectionalSettings settings, EyePathState state) {
  return state.scatterings >= settings.max_scatterings && !(state.flags & EYE_PATH_CHAIN);
}

// Work-item i: places 8 i to 8 i + 7 of the queue. All active paths have visited equally many vertices.
__kernel void draw_eye_numbers(const BidirectionalSettings settings, uint seed, uint sample_index,
                               __global const uint* restrict queue, __global const uint* restrict active,
                               __global const EyePathState* restrict states, __global float* restrict numbers) {
  const uint i = get_global_id(0), count = active[0];
  if (8u * i >= count) return;
  const uint8 paths = queued_paths8(queue, i, count);
  const uint vertex = states[paths.s0].segment;
  // Paths scatter for the last time at the same vertex, except for those that met mirrors first.
  if (vertex >= settings.max_scatterings && scatters_nothing(settings, states[paths.s0]) &&
      scatters_nothing(settings, states[paths.s1]) && scatters_nothing(settings, states[paths.s2]) &&
      scatters_nothing(settings, states[paths.s3]) && scatters_nothing(settings, states[paths.s4]) &&
      scatters_nothing(settings, states[paths.s5]) && scatters_nothing(settings, states[paths.s6]) &&
      scatters_nothing(settings, states[paths.s7]))
    return;
  // make_pixel_sampler()
  const uint8 seeds = hash_uints(paths + hash_uint(hash_uint(seed)));
  draw_vertex_numbers8(seeds, (uint8)(sample_index), LUCARIUM_SAMPLER_SOBOL, vertex, false, i, numbers);
}
