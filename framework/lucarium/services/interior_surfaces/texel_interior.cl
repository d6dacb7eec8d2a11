// SPDX-License-Identifier: Apache-2.0
// Which random points of texel sides are interior, by walks in rounds: one from every point that is still in doubt.
#include "lucarium/atlas_surface.clh"
#include "lucarium/services/interior_surfaces/walk.clh"
#include "lucarium/shared/interior_point.h"

#define INTERIOR_SEED 0x70726f62u
#define STATE_CAUGHT 0xffu  // of a state: walks that were caught, of the first INTERIOR_COMMON rounds
#define STATE_OPEN 0x100u   // of a state: some walk escaped
#define INTERIOR_COMMON 8u  // rounds that all points of a texel side take part in while one of them has not escaped

// A chunk of points begins: point i is point i % samples of texel side first + i / samples.
__kernel void begin_interior(uint count, __global uint* restrict states, __global uint* restrict wanted,
                             __global uint* restrict total) {
  const uint i = get_global_id(0);
  if (i == 0u) total[0] = count;
  if (i >= count) return;
  states[i] = 0u;
  wanted[i] = 1u;
}

// The first ray of a walk from each listed point.
__kernel void aim_texel_walks(LUCARIUM_SCENE_PARAMETERS AtlasInfo atlas_info,
                              __global const AtlasSample* restrict atlas_samples, uint samples, uint first,
                              uint round_index, __global const uint* restrict list,
                              __global const uint* restrict active,
                              LUCARIUM_RAY_ENDS_PARAMETER(ends) __global Ray* restrict rays,
                              __global uchar* restrict escaped) {
  const uint j = get_global_id(0);
  if (j >= active[0]) return;
  LUCARIUM_SCENE_BIND(scene);
  const uint point = first * samples + list[j];
  const AtlasSample sample = atlas_samples[point];
  const Surface surface = atlas_surface(&scene, atlas_info, point / samples, sample.triangle, sample.b1, sample.b2);
  const float4 u = random_float4(INTERIOR_SEED, point, round_index);
  const Ray ray = walk_ray(&surface, surface.n_g, u.xy, as_uint(u.z));
  rays[j] = ray;
  LUCARIUM_STORE_RAY_ENDS(ends, j, ray_ends(&surface, ray.direction.xyz));
  escaped[j] = 0;
}

__kernel void judge_texel_walks(uint round_index, __global const uint* restrict list,
                                __global const uint* restrict active, __global const uchar* restrict escaped,
                                __global uint* restrict states) {
  const uint j = get_global_id(0);
  if (j >= active[0]) return;
  if (escaped[j])
    states[list[j]] |= STATE_OPEN;
  else if (round_index < INTERIOR_COMMON)
    states[list[j]] += 1u;
}

// Which points take part in the round after `round_index`: those from which no walk has escaped, and in the first
// rounds their neighbours too: they measure the share of walks that are caught although their point is not interior.
__kernel void choose_texel_walks(uint sides, uint samples, uint round_index, __global const uint* restrict states,
                                 __global uint* restrict wanted) {
  const uint side = get_global_id(0);
  if (side >= sides) return;
  uint doubtful = 0u;
  for (uint k = 0u; k < samples; ++k) doubtful += !(states[side * samples + k] & STATE_OPEN);
  const bool joined = doubtful > 0u && round_index + 1u < INTERIOR_COMMON;
  for (uint k = 0u; k < samples; ++k) wanted[side * samples + k] = joined || !(states[side * samples + k] & STATE_OPEN);
}

// shares: x share of the texel side's area that is not interior; y of its walks that are caught, the share that begins
// there (1 where nothing is interior). interior: a bit per point.
__kernel void finish_interior(uint first, uint sides, uint samples, __global const uint* restrict states,
                              __global float2* restrict shares, __global uint* restrict interior) {
  const uint i = get_global_id(0);
  if (i >= sides) return;
  uint bits = 0u, caught = 0u;
  for (uint k = 0u; k < samples; ++k) {
    const uint state = states[i * samples + k];
    if (state & STATE_OPEN)
      caught += state & STATE_CAUGHT;
    else
      bits |= 1u << k;
  }
  const uint lost = popcount(bits);
  // Of walks from all over the texel side, lost / samples are caught since they begin inside, and so are others.
  const float from_open = (float)caught / (float)INTERIOR_COMMON;
  shares[first + i] =
      (float2)(1.0f - (float)lost / (float)samples, lost > 0u ? from_open / (from_open + (float)lost) : 1.0f);
  interior[first + i] = bits;
}
