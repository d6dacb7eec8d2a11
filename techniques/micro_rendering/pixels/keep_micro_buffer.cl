// SPDX-License-Identifier: Apache-2.0
// The micro-buffer of the inspected pixel, for its layer.
#include "lucarium/shared/dialect.h"

// Copies it before another batch overwrites it.
__kernel void keep_micro_buffer(__global const float4* restrict micro_buffer, uint count,
                                __global float4* restrict kept) {
  const uint i = get_global_id(0);
  if (i < count) kept[i] = micro_buffer[i];
}
