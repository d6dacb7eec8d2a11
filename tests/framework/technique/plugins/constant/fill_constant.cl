// SPDX-License-Identifier: Apache-2.0
#include "lucarium/shared/dialect.h"

/// Adds `colour` to the running sum of every pixel.
kernel void fill_constant(global float4* sum, const float4 colour, const uint pixels) {
  const uint i = (uint)get_global_id(0);
  if (i < pixels) sum[i] += colour;
}
