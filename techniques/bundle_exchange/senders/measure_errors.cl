// SPDX-License-Identifier: Apache-2.0
// How sure the displayed irradiance of texel sides is.
#include "bundle_exchange/base/exchange_layout.clh"
#include "lucarium/math.clh"

// Standard error of a texel side's displayed irradiance and the irradiance itself, both over pi, luminance, times its
// area: what the relative error of the whole is made of. indirect_errors: the error of what is reflected alone; both
// are taken for independent.
__kernel void measure_errors(uint sides, __global const float4* restrict albedo,
                             __global const float4* restrict display, __global const float4* restrict statistics,
                             __global float* restrict errors, __global float* restrict indirect_errors,
                             __global float* restrict values) {
  const uint side = get_global_id(0);
  if (side >= sides) return;
  float3 indirect = (float3)(0.0f);
  for (uint channel = BUNDLE_FIRST; channel < BUNDLE_CHANNELS; ++channel)
    indirect += side_mean(display[(size_t)channel * sides + side]);
  float value = luminance(indirect), variance = ratio_variance(statistics[side], value);
  indirect_errors[side] = albedo[side].w * sqrt(variance);
#ifdef BUNDLE_EXCHANGED
  const float direct = luminance(side_mean(display[side]));
  variance += ratio_variance(statistics[sides + side], direct);
  value += direct;
#endif
  errors[side] = albedo[side].w * sqrt(variance);
  values[side] = albedo[side].w * value;
}

__kernel void copy_sums(__global const float* restrict error, __global const float* restrict indirect_error,
                        __global const float* restrict value, __global float* restrict sums) {
  sums[0] = error[0];
  sums[1] = indirect_error[0];
  sums[2] = value[0];
}
