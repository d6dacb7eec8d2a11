// SPDX-License-Identifier: Apache-2.0
// Adds a batch to the means of texel sides.
#include "bundle_exchange/base/exchange_layout.clh"
#include "lucarium/math.clh"

float4 batch_statistics(float x, float n) { return (float4)(x * x, x * n, n * n, n); }

// The Monte Carlo sum over directions of equation 2 (Hermes et al. 2010), a batch at a time, as the two sums whose
// ratio side_mean() takes. The paper's receiver atlas is S, from which the next batch sends (section 5.5): S =
// sender_scale S + sender_weight batch, D += display_weight batch (the channel of emission: D += batch). visible: xy +=
// sums of w, of rays that met a texel side and of all. statistics: sums over batches of X^2, X N, N^2, N with X =
// luminance of v sum w L (all channels of reflected light), N = v sum w, v display_weight, from which the variance of
// D's ratio follows; behind those of all texel sides (BUNDLE_EXCHANGED) the same of the channel of emission, v = 1.
__kernel void accumulate_batch(uint sides, float sender_scale, float sender_weight, float display_weight,
                               __global const float4* restrict records, __global float4* restrict senders,
                               __global float4* restrict display, __global float2* restrict visible,
                               __global float4* restrict statistics) {
  const uint side = get_global_id(0);
  if (side >= sides) return;
  const __global float4* record = records + (size_t)side * BUNDLE_RECORD;
  const float weight = record[1].w, seen = record[0].w;
  float3 total = (float3)(0.0f);
  // Emitted light is added as it comes: its senders do not change.
#ifdef BUNDLE_EXCHANGED
  display[side] += (float4)(record[1].xyz, weight);
  statistics[sides + side] += batch_statistics(luminance(record[1].xyz), weight);
#endif
  // Each channel of reflected light: one average forgets, the other hardly does.
  for (uint channel = BUNDLE_FIRST; channel < BUNDLE_CHANNELS; ++channel) {
    const float4 batch = (float4)(record[2u * channel + 1u].xyz, weight);
    const size_t sender = (size_t)(channel - BUNDLE_FIRST) * sides + side;
    senders[sender] = sender_scale * senders[sender] + sender_weight * batch;
    display[(size_t)channel * sides + side] += display_weight * batch;
    total += batch.xyz;
  }
  // Statistics for the balance and for the variance of the ratio.
  visible[side] += (float2)(seen, weight);
  statistics[side] += batch_statistics(display_weight * luminance(total), display_weight * weight);
}
