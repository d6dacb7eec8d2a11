// SPDX-License-Identifier: Apache-2.0
// Adds the light that a pixel sees come straight from a lamp or the sky.
#include "lucarium/shared/gbuffer.h"

// emission: running sum per pixel [cd/m²]; xyz, w unused.
__kernel void add_emission(__global const GBufferPoint* restrict points, const uint count,
                           __global float4* restrict emission) {
  const uint i = (uint)get_global_id(0);
  if (i < count) emission[i] += (float4)(points[i].emission.xyz, 0.0f);
}
