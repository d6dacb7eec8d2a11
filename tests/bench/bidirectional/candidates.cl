// SPDX-License-Identifier: Apache-2.0
// Targets of candidates alone, as connections compare them.
#define LUCARIUM_PATH_MIS_POWER 1
#include "bidirectional_vpl/light/candidates.clh"

// Surface i of a unit box compares `compared` blocks of the table from a place of its own on.
__kernel void compare_candidates(__global const float* restrict table, uint blocks, uint compared,
                                 __global float* restrict sums) {
  const uint i = (uint)get_global_id(0);
  CandidateTarget target;
  target.position = (float3)((i & 255u) / 256.0f, 0.0f, (i >> 8 & 255u) / 256.0f);
  target.n_s = (float3)(0.0f, 1.0f, 0.0f);
  target.mirrored = (float3)(0.0f, 1.0f, 0.0f);
  target.diffuse = 0.2f;
  target.glossy = 0.0f;
  target.sharpness = 0.0f;
  target.mis = 0.5f;
  target.samples = 6.4f;
  target.both_sides = false;
  const uint first = i * 2654435761u % (blocks - compared);
  float8 sum = 0.0f;
  for (uint b = 0; b < compared; ++b) sum += candidate_targets(table, first + b, &target);
  sums[i] = sum.s0 + sum.s1 + sum.s2 + sum.s3 + sum.s4 + sum.s5 + sum.s6 + sum.s7;
}
