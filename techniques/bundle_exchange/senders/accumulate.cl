// SPDX-License-Identifier: Apache-2.0
// Adds a batch to what texel sides hold for good, tells how sure that is, and makes of it what is displayed.
#include "bundle_exchange/base/exchange_layout.clh"
#include "lucarium/math.clh"
#include "lucarium/shared/surface_atlas.h"

float4 batch_statistics(float x, float n) { return (float4)(x * x, x * n, n * n, n); }

// The sum over directions of equation 2 (Hermes et al. 2010), a batch at a time, as the two sums whose ratio
// side_mean() takes. The paper's receiver atlas is S, from which the next batch sends (section 5.5):
// S = sender_scale S + sender_weight batch, D += display_weight batch (the channel of emission: D += batch).
// visible: xy += sums of w, of rays that met a texel side and of all. statistics: sums over batches of X^2, X N, N^2, N
// with X = luminance of v sum w L (all channels of reflected light), N = v sum w, v display_weight, from which the
// variance of D's ratio follows; behind those of all texel sides (BUNDLE_EXCHANGED) the same of the channel of
// emission, v = 1.
__kernel void accumulate_batch(uint sides, float sender_scale, float sender_weight, float display_weight,
                               __global const float4* restrict records, __global float4* restrict senders,
                               __global float4* restrict display, __global float2* restrict visible,
                               __global float4* restrict statistics) {
  const uint side = get_global_id(0);
  if (side >= sides) return;
  const global float4* record = records + (size_t)side * BUNDLE_RECORD;
  const float weight = record[1].w, seen = record[0].w;
  float3 total = (float3)(0.0f);
#ifdef BUNDLE_EXCHANGED
  display[side] += (float4)(record[1].xyz, weight);
  statistics[sides + side] += batch_statistics(luminance(record[1].xyz), weight);
#endif
  for (uint channel = BUNDLE_FIRST; channel < BUNDLE_CHANNELS; ++channel) {
    const float4 batch = (float4)(record[2u * channel + 1u].xyz, weight);
    const size_t sender = (size_t)(channel - BUNDLE_FIRST) * sides + side;
    senders[sender] = sender_scale * senders[sender] + sender_weight * batch;
    display[(size_t)channel * sides + side] += display_weight * batch;
    total += batch.xyz;
  }
  visible[side] += (float2)(seen, weight);
  statistics[side] += batch_statistics(display_weight * luminance(total), display_weight * weight);
}

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
  const float4 before = one_by_one ? finished[side] : (float4)(0.0f);
  float3 total = before.xyz;
  float weight = before.w;
  for (uint channel = BUNDLE_FIRST; channel < BUNDLE_CHANNELS; ++channel) {
    const float4 sums = display[(size_t)channel * sides + side];
    total += share * side_mean(sums);
    weight = fmax(weight, sums.w);
  }
  const float open = weight > 0.0f ? accessibility[side] : 0.0f;
  shown[side] = open * (float4)(total, 1.0f);
#ifdef BUNDLE_EXCHANGED
  const float4 emitted = display[side];
  shown_direct[side] = (emitted.w > 0.0f ? accessibility[side] : 0.0f) * (float4)(side_mean(emitted), 1.0f);
#endif
#ifdef BUNDLE_CHAINS
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

// End of a bounce that was computed alone: what it brought is kept, and is what the next one sends. The exchange of
// sender and receiver atlas after N directions (Hermes et al. 2010, section 5.2, ping-pong).
__kernel void finish_bounce(uint sides, __global float4* restrict display, __global float4* restrict senders,
                            __global float4* restrict finished) {
  const uint side = get_global_id(0);
  if (side >= sides) return;
  const size_t own = (size_t)BUNDLE_FIRST * sides + side;
  const float4 bounce = display[own];
  finished[side] = (float4)(finished[side].xyz + side_mean(bounce), fmax(finished[side].w, bounce.w));
  senders[side] = bounce;
  display[own] = (float4)(0.0f);
}

__kernel void copy_sums(__global const float* restrict error, __global const float* restrict indirect_error,
                        __global const float* restrict value, __global float* restrict sums) {
  sums[0] = error[0];
  sums[1] = indirect_error[0];
  sums[2] = value[0];
}

// Diffuse albedo and emission of texel sides; w: area times accessibility [m^2].
__kernel void copy_materials(uint sides, __global const AtlasTexel* restrict atlas_texels,
                             __global const AtlasMaterial* restrict atlas_materials,
                             __global const float* restrict accessibility, __global float4* restrict albedo,
                             __global float4* restrict emission) {
  const uint side = get_global_id(0);
  if (side >= sides) return;
  const float area = atlas_texels[side].area * accessibility[side];
  albedo[side] = (float4)(atlas_materials[side].diffuse.xyz, area);
  emission[side] = (float4)(atlas_materials[side].emission.xyz, area);
}
