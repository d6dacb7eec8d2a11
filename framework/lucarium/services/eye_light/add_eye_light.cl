// SPDX-License-Identifier: Apache-2.0
// Adds what the G-buffer's points emit, and the direct light that they reflect in a sample (w: light samples), and says
// how far both together lie from the samples before.
#include "lucarium/services/layer_sums/layer_sums.clh"
#include "lucarium/shared/gbuffer.h"

__kernel void add_eye_light(__global const GBufferPoint* restrict points, uint count,
                            __global const float4* restrict direct_sample, __global float4* restrict emission,
                            __global float4* restrict direct, __global float* restrict deviations) {
  const uint i = (uint)get_global_id(0);
  if (i >= count) return;
  const float samples = emission[i].w;
  const float3 light = points[i].emission.xyz + direct_sample[i].xyz / fmax(direct_sample[i].w, 1.0f);
  const float3 before = emission[i].xyz / fmax(samples, 1.0f) + direct[i].xyz / fmax(direct[i].w, 1.0f);
  deviations[i] = sample_deviation(light, before, samples);
  emission[i] = add_sample(emission[i], points[i].emission.xyz);
  direct[i] += direct_sample[i];
}
