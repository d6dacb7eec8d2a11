// SPDX-License-Identifier: Apache-2.0
// What every slot sends during the next batch, and the balance of sent and held power that scales it.
#include "bundle_exchange/exchange_layout.clh"

// albedo: xyz diffuse albedo c, w area [m^2]. senders, display: S and D, channel-major, S without the channel of emission.
// scale[0]: of what a self-fed channel has received. feedback_share: of all that has been received. Clears the sums of the exchange records. diffuse (BUNDLE_HOPS): what
// is sent, BUNDLE_REFLECTED channels per slot, for chains of specular vertices that end there.
__kernel void make_senders(uint slots, __global const float4* restrict albedo, __global const float4* restrict emission,
                           __global const float4* restrict light_samples, __global const float4* restrict senders,
                           __global const float4* restrict display, __global const float4* restrict scale,
                           float direct_share, float feedback_share, __global float4* restrict diffuse,
                           __global float4* restrict records) {
  const uint slot = get_global_id(0);
  if (slot >= slots) return;
  global float4* record = records + (size_t)slot * BUNDLE_RECORD;
#ifdef BUNDLE_EMISSION
  record[0] = (float4)(emission[slot].xyz, 0.0f);
  record[1] = (float4)(0.0f);
#endif
  const float3 c = albedo[slot].xyz;
  float3 held = direct_share * direct_mean(slot, light_samples, display);
#ifdef BUNDLE_SELF_FED
  held += feedback_share * scale[0].xyz * slot_mean(senders[slot]);
#endif
  for (uint channel = BUNDLE_FIRST; channel < BUNDLE_CHANNELS; ++channel) {
    record[2u * channel] = (float4)(c * held, 0.0f);
#ifdef BUNDLE_HOPS
    diffuse[(size_t)slot * BUNDLE_REFLECTED + channel - BUNDLE_FIRST] = (float4)(c * held, 0.0f);
#endif
    record[2u * channel + 1u] = (float4)(0.0f);
    held = feedback_share * slot_mean(senders[(size_t)(channel - BUNDLE_FIRST) * slots + slot]);
  }
}

#define BALANCE_CHUNK 1024u

// Numerator and denominator of the balance over a chunk of slots:
//   s = sum A v c e_dir / sum A (1 - v c) e_S,   v: share of a slot's rays that meet a slot (visible: sum w v, sum w).
// Scaled by s, what senders deliver is what receivers hold.
__kernel void balance_chunks(uint slots, __global const float4* restrict albedo,
                             __global const float4* restrict light_samples, __global const float4* restrict senders,
                             __global const float4* restrict display, __global const float2* restrict visible,
                             __global float4* restrict chunks) {
  const uint chunk = get_global_id(0), first = chunk * BALANCE_CHUNK;
  if (first >= slots) return;
  float3 delivered = (float3)(0.0f), held = (float3)(0.0f);
  for (uint slot = first; slot < min(first + BALANCE_CHUNK, slots); ++slot) {
    const float2 seen = visible[slot];
    if (seen.y <= 0.0f) continue;
    const float4 c = albedo[slot];
    const float3 sent = seen.x / seen.y * c.xyz;
    delivered += c.w * sent * direct_mean(slot, light_samples, display);
    held += c.w * ((float3)(1.0f) - sent) * slot_mean(senders[slot]);
  }
  chunks[2u * chunk] = (float4)(delivered, 0.0f);
  chunks[2u * chunk + 1u] = (float4)(held, 0.0f);
}

// One work-item. Clamped, since a few directions may hold anything.
__kernel void balance_scale(uint count, __global const float4* restrict chunks, __global float4* restrict scale) {
  float3 delivered = (float3)(0.0f), held = (float3)(0.0f);
  for (uint i = 0; i < count; ++i) {
    delivered += chunks[2u * i].xyz;
    held += chunks[2u * i + 1u].xyz;
  }
  const float3 ratio = clamp(delivered / held, 0.125f, 8.0f);
  scale[0] = (float4)(held.x > 0.0f ? ratio.x : 1.0f, held.y > 0.0f ? ratio.y : 1.0f, held.z > 0.0f ? ratio.z : 1.0f, 0.0f);
}
