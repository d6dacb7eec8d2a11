// SPDX-License-Identifier: Apache-2.0
// Jacobi iteration: the irradiance that nodes have gathered goes to their leaves.
#include "lucarium/shared/dialect.h"

// The push step (Ritschel et al. 2009, section 4). Leaf i: direct light and what its node of the cut has gathered;
// irradiance and not radiance is pushed, so that each leaf keeps its own albedo.
__kernel void push_irradiance(uint count, __global const uint* restrict leaf_results,
                              __global const float4* restrict direct, __global const float4* restrict gathered,
                              __global float4* restrict irradiance) {
  const uint i = get_global_id(0);
  if (i < count) irradiance[i] = (float4)(direct[i].xyz + gathered[leaf_results[i]].xyz, 0.0f);
}
