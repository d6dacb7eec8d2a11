// SPDX-License-Identifier: Apache-2.0
// What texel sides send besides their diffuse light as it is known (SideState), mixed into means of it.
#include "bundle_exchange/base/exchange_layout.clh"
#include "lucarium/services/layer_sums/layer_sums.clh"

// Radiance that the balance adds to what a texel side sends in the batch that begins: c (s - 1) e_S, with S and s as
// make_senders() has read them.
__kernel void mix_balance(uint sides, float weight, __global const float4* restrict albedo,
                          __global const float4* restrict senders, __global const float4* restrict scale,
                          __global float4* restrict balance) {
  const uint side = get_global_id(0);
  if (side >= sides) return;
  float3 added = (float3)(0.0f);
#ifdef BUNDLE_SELF_FED
  added = albedo[side].xyz * (scale[0].xyz - 1.0f) * side_mean(senders[side]);
#endif
  balance[side] = mix_sample(balance[side], added, weight);
}

// Entry i of the direction history: radiance that it reflects of earlier directions along this one. The record holds it
// beside the diffuse light and light samples, of which there are `lit`, for halves of texel sides in turn
// (apply_contributions(), whose order of additions leaves 0 where nothing is reflected).
#ifdef BUNDLE_CHAINS
__kernel void mix_history(uint count, float weight, __global const uint* restrict list,
                          __global const float4* restrict records, __global const float4* restrict diffuse, uint lit,
                          __global const float4* restrict light, __global float4* restrict history) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const uint side = list[i];
  float3 reflected = (float3)(0.0f);
  for (uint k = 0u; k < BUNDLE_REFLECTED; ++k) {
    float3 otherwise = diffuse[(size_t)side * BUNDLE_REFLECTED + k].xyz;
    if (lit) otherwise += light[(size_t)(i % lit) * BUNDLE_REFLECTED + k].xyz;
    reflected += records[(size_t)side * BUNDLE_RECORD + 2u * (BUNDLE_FIRST + k)].xyz - otherwise;
  }
  history[side] = mix_sample(history[side], reflected, weight);
}
#endif
