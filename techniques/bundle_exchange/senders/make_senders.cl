// SPDX-License-Identifier: Apache-2.0
// What every texel side sends during the next batch.
#include "bundle_exchange/base/exchange_layout.clh"

// Sets L_x of the next batch's equation 3 (Hermes et al. 2010): emission, and c times the irradiance over pi that is
// known: f_r of a receiver, which the paper applies at every transfer, is applied once, when the receiver sends. With
// the means read from S, light of all path lengths so far travels at once (section 5.5, interleaved light transfer).
//
// Emitters send what they emit in the channel of emission (section 5.1, area lights as surfaces).
//
// albedo: xyz diffuse albedo c, w area [m^2]. senders, display: S and D, channel-major, S without the channel of
// emission. scale[0]: of what a self-fed channel has received. feedback_share: of all that has been received. Clears
// the sums of the exchange records. diffuse (BUNDLE_CHAINS): what is sent, BUNDLE_REFLECTED channels per texel side,
// for chains of specular vertices that end there.
__kernel void make_senders(uint sides, __global const float4* restrict albedo, __global const float4* restrict emission,
                           __global const float4* restrict light_samples, __global const float4* restrict senders,
                           __global const float4* restrict display, __global const float4* restrict scale,
                           float direct_share, float feedback_share, __global float4* restrict diffuse,
                           __global float4* restrict records) {
  const uint side = get_global_id(0);
  if (side >= sides) return;
  __global float4* record = records + (size_t)side * BUNDLE_RECORD;
#ifdef BUNDLE_EMISSION
  record[0] = (float4)(emission[side].xyz, 0.0f);
  record[1] = (float4)(0.0f);
#endif
  const float3 c = albedo[side].xyz;
  // Begin with direct light; a channel that feeds itself adds its own mean, later channels each send the one before.
  float3 held = direct_share * direct_mean(side, light_samples, display);
#ifdef BUNDLE_SELF_FED
  held += feedback_share * scale[0].xyz * side_mean(senders[side]);
#endif
  for (uint channel = BUNDLE_FIRST; channel < BUNDLE_CHANNELS; ++channel) {
    record[2u * channel] = (float4)(c * held, 0.0f);
#ifdef BUNDLE_CHAINS
    diffuse[(size_t)side * BUNDLE_REFLECTED + channel - BUNDLE_FIRST] = (float4)(c * held, 0.0f);
#endif
    record[2u * channel + 1u] = (float4)(0.0f);
    held = feedback_share * side_mean(senders[(size_t)(channel - BUNDLE_FIRST) * sides + side]);
  }
}
