// SPDX-License-Identifier: Apache-2.0
// Means over an image of how far a part's samples scatter (layer_spread.h).
#include "lucarium/math.clh"

float3 mean_light(float4 sum) { return sum.w > 0.0f ? sum.xyz / sum.w : (float3)(0.0f); }

// Sums over runs of `run` pixels: x deviations and y squares of indirect light, both over r^2 + `least`; z luminance of
// what is shown, r.
__kernel void sum_spread(uint pixels, uint run, float least, __global const float* restrict deviations,
                         __global const float4* restrict emission, __global const float4* restrict direct,
                         __global const float4* restrict indirect, __global float4* restrict sums) {
  const uint first = (uint)get_global_id(0) * run, end = min(first + run, pixels);
  float4 sum = (float4)(0.0f);
  for (uint i = first; i < end; ++i) {
    const float3 reflected = mean_light(indirect[i]);
    const float3 shown = mean_light(emission[i]) + mean_light(direct[i]) + reflected;
    const float weight = 1.0f / fmax(dot(shown, shown) / 3.0f + least, 1e-30f);
    sum += (float4)(weight * deviations[i], weight * dot(reflected, reflected) / 3.0f, luminance(shown), 0.0f);
  }
  sums[get_global_id(0)] = sum;
}
