// SPDX-License-Identifier: Apache-2.0
// The balance of sent and held power, which scales what a channel that feeds itself sends: what texel sides hold, what
// they deliver to each other, and what specular lobes deliver besides.
#include "bundle_exchange/base/exchange_layout.clh"
#include "bundle_exchange/shared/balance.h"

#define BALANCE_MAX_SPECULAR 0.2f

// Numerator and denominator of the balance over a chunk of texel sides (balance_scale), without specular light:
//   xyz: sum V c e_dir, w: sum U             xyz: sum (U - V c) e_S, w: sum U e_S, of the three colours
// V: what other texel sides count of a texel side's rays, U: what it counts itself (visible).
__kernel void balance_chunks(uint sides, __global const float4* restrict albedo,
                             __global const float4* restrict light_samples, __global const float4* restrict senders,
                             __global const float4* restrict display, __global const float2* restrict visible,
                             __global float4* restrict chunks) {
  const uint chunk = get_global_id(0), first = chunk * BALANCE_CHUNK;
  if (first >= sides) return;
  float4 delivered = (float4)(0.0f), held = (float4)(0.0f);
  for (uint side = first; side < min(first + BALANCE_CHUNK, sides); ++side) {
    const float2 seen = visible[side];
    if (seen.y <= 0.0f) continue;
    const float3 sent = seen.x * albedo[side].xyz, received = side_mean(senders[side]);
    delivered += (float4)(sent * direct_mean(side, light_samples, display), seen.y);
    held += (float4)(((float3)(seen.y) - sent) * received, seen.y * (received.x + received.y + received.z));
  }
  chunks[2u * chunk] = delivered;
  chunks[2u * chunk + 1u] = held;
}

// One work-item. Scaled by
//   s = (sum V c e_dir + P) / sum (U - V c) e_S,
// what is delivered is what receivers hold: s sum U e_S = sum V c (e_dir + s e_S) + P. P is the power that specular
// lobes deliver: received in the batch less sent diffusely (specular: of S, sum of w L, sum of w over all rays). It is
// not scaled, although some of it is light that texel sides held. This only slows the correction down while P is small;
// if P is large, s = 1. Clamped, since the sums over a few directions may be anything.
__kernel void balance_scale(uint count, __global const float4* restrict chunks,
                            __global const float4* restrict specular, __global float4* restrict scale) {
  float4 delivered = (float4)(0.0f), held = (float4)(0.0f);
  for (uint i = 0; i < count; ++i) {
    delivered += chunks[2u * i];
    held += chunks[2u * i + 1u];
  }
  const float3 by_lobes = specular[0].w > 0.0f ? specular[0].xyz * (delivered.w / specular[0].w) : (float3)(0.0f);
  const float3 ratio = clamp((delivered.xyz + by_lobes) / held.xyz, 0.125f, 8.0f);
  const bool mirrored = by_lobes.x + by_lobes.y + by_lobes.z > BALANCE_MAX_SPECULAR * held.w;
  const int3 balanced = held.xyz > 0.0f && (int3)(mirrored ? 0 : -1);
  scale[0] = (float4)(select((float3)(1.0f), ratio, balanced), 0.0f);
}

// Power that specular lobes have delivered to a chunk of texel sides in the batch: reflected light received, less the
// light that texel sides sent diffusely. A texel side's record holds the weight with which others count its rays, so
// that over all texel sides the sum of w L received is the sum of the radiance sent times that weight.
#if defined(BUNDLE_CHAINS) && defined(BUNDLE_SELF_FED)
__kernel void specular_chunks(uint sides, __global const float4* restrict diffuse,
                              __global const float4* restrict records, __global float4* restrict chunks) {
  const uint chunk = get_global_id(0), first = chunk * BALANCE_CHUNK;
  if (first >= sides) return;
  float4 sum = (float4)(0.0f);
  for (uint side = first; side < min(first + BALANCE_CHUNK, sides); ++side) {
    const __global float4* record = records + (size_t)side * BUNDLE_RECORD;
    sum += (float4)(record[2u * BUNDLE_FIRST + 1u].xyz - record[0].w * diffuse[side].xyz, record[1].w);
  }
  chunks[chunk] = sum;
}

// One work-item. specular follows S: sender_scale specular + sender_weight batch.
__kernel void specular_sum(uint count, float sender_scale, float sender_weight, __global const float4* restrict chunks,
                           __global float4* restrict specular) {
  float4 sum = (float4)(0.0f);
  for (uint i = 0; i < count; ++i) sum += chunks[i];
  specular[0] = sender_scale * specular[0] + sender_weight * sum;
}
#endif
