// SPDX-License-Identifier: Apache-2.0
// Means over an image of how far a part's samples scatter (layer_spread.h).
#include "lucarium/math.clh"

float3 mean_light(float4 sum) { return sum.w > 0.0f ? sum.xyz / sum.w : (float3)(0.0f); }

// Sums over runs of `run` pixels: x deviations and y squares of indirect light, both over r^2 + `least`; z luminance of
// what is shown, r; w pixels. sky: more of indirect light where `has_sky`, by the same weights. Pixels that are not
// finite are left out, as in metrics.
__kernel void sum_spread(uint pixels, uint run, float least, __global const float* restrict deviations,
                         __global const float4* restrict emission, __global const float4* restrict direct,
                         __global const float4* restrict indirect, uint has_sky, __global const float4* restrict sky,
                         __global float4* restrict sums) {
  const uint first = (uint)get_global_id(0) * run, end = min(first + run, pixels);
  float4 sum = (float4)(0.0f);
  for (uint i = first; i < end; ++i) {
    float4 gathered = indirect[i];
    if (has_sky) gathered.xyz += sky[i].xyz;
    const float3 reflected = mean_light(gathered);
    const float3 shown = mean_light(emission[i]) + mean_light(direct[i]) + reflected;
    const float weight = 1.0f / fmax(dot(shown, shown) / 3.0f + least, 1e-30f);
    const float4 term =
        (float4)(weight * deviations[i], weight * dot(reflected, reflected) / 3.0f, luminance(shown), 1.0f);
    if (all(isfinite(term))) sum += term;
  }
  sums[get_global_id(0)] = sum;
}
