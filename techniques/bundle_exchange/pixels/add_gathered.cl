// SPDX-License-Identifier: Apache-2.0
// A batch of gathered light counts.
#include "lucarium/shared/dialect.h"

// A batch counts: its light and the number of its directions (w of the first contribution).
__kernel void add_gathered(uint count, uint directions, __global const float4* restrict contribution,
                           __global float4* restrict gathered) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  gathered[2u * i] += (float4)(contribution[2u * i].xyz, (float)directions);
  gathered[2u * i + 1u] += (float4)(contribution[2u * i + 1u].xyz, 0.0f);
}
