// SPDX-License-Identifier: Apache-2.0
// Adds what the G-buffer's points emit, and the direct light that they reflect in a sample (w: light samples).
#include "lucarium/services/layer_sums/layer_sums.clh"
#include "lucarium/shared/gbuffer.h"

__kernel void add_eye_light(__global const GBufferPoint* restrict points, uint count,
                            __global const float4* restrict direct_sample, __global float4* restrict emission,
                            __global float4* restrict direct) {
  const uint i = (uint)get_global_id(0);
  if (i >= count) return;
  emission[i] = add_sample(emission[i], points[i].emission.xyz);
  direct[i] += direct_sample[i];
}
