// SPDX-License-Identifier: Apache-2.0
// What is displayed of the means of texel sides.
#include "bundle_exchange/base/exchange_layout.clh"

// Indirect irradiance over pi of every texel side, all bounces, times accessibility, which is w (0 where no ray has
// come yet): what is hardly seen counts little in interpolation. shown_direct (BUNDLE_EXCHANGED): the same of exchanged
// emitted light. radiance (BUNDLE_CHAINS): what texel sides reflect diffusely of all the light, BUNDLE_REFLECTED
// channels each, as diffuse of make_senders.
__kernel void make_display(uint sides, float share, __global const float* restrict accessibility,
                           __global const float4* restrict albedo, __global const float4* restrict light_samples,
                           uint one_by_one, __global const float4* restrict finished,
                           __global const float4* restrict display, __global float4* restrict shown,
                           __global float4* restrict shown_direct, __global float4* restrict radiance) {
  const uint side = get_global_id(0);
  if (side >= sides) return;
  // Sum the means of all bounces, those that are finished included.
  const float4 before = one_by_one ? finished[side] : (float4)(0.0f);
  float3 total = before.xyz;
  float weight = before.w;
  for (uint channel = BUNDLE_FIRST; channel < BUNDLE_CHANNELS; ++channel) {
    const float4 sums = display[(size_t)channel * sides + side];
    total += share * side_mean(sums);
    weight = fmax(weight, sums.w);
  }
  // Weight interpolation by accessibility.
  const float accessible = weight > 0.0f ? accessibility[side] : 0.0f;
  shown[side] = accessible * (float4)(total, 1.0f);
#ifdef BUNDLE_EXCHANGED
  const float4 emitted = display[side];
  shown_direct[side] = (emitted.w > 0.0f ? accessibility[side] : 0.0f) * (float4)(side_mean(emitted), 1.0f);
#endif
#ifdef BUNDLE_CHAINS
  // Reflect what the texel side holds: light of its own, then bounce after bounce.
  float3 held = direct_mean(side, light_samples, display);
#ifdef BUNDLE_SELF_FED
  held += total;
#endif
  for (uint k = 0u; k < BUNDLE_REFLECTED; ++k) {
    radiance[(size_t)side * BUNDLE_REFLECTED + k] = (float4)(albedo[side].xyz * held, 0.0f);
    held = side_mean(display[(size_t)(BUNDLE_FIRST + k) * sides + side]);
  }
#endif
}
