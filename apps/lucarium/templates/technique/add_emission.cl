// SPDX-License-Identifier: Apache-2.0
// Adds the light that a pixel sees come straight from a lamp or the sky.
#include "lucarium/services/layer_sums/layer_sums.clh"
#include "lucarium/shared/gbuffer.h"

// emission: sums per pixel [cd/m²]; xyz, w samples.
__kernel void add_emission(__global const GBufferPoint* restrict points, uint count,
                           __global float4* restrict emission) {
  const uint i = (uint)get_global_id(0);
  if (i < count) emission[i] = add_sample(emission[i], points[i].emission.xyz);
}
