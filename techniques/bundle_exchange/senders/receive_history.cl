// SPDX-License-Identifier: Apache-2.0
// Glossy interreflections (Hermes et al. 2010, section 5.4), first half: texel sides remember what the last directions
// of the sequence brought. The second half: send_history.cl.
//
// history: [direction modulo its length][channel][entry of the list of texel sides], xyz: sum of w L, w: sum of w.
#include "bundle_exchange/base/exchange_layout.clh"
#include "bundle_exchange/shared/history_step.h"

// Light that arrived through channel `output` of what is reflected: that of one scattering less.
float3 history_input(const __global float4* record, uint output) {
  float3 light = (float3)(0.0f);
#ifdef BUNDLE_EMISSION
  if (output == 0u) light = record[1].xyz;
#endif
#ifdef BUNDLE_SELF_FED
  light += record[2u * BUNDLE_FIRST + 1u].xyz;
#else
  if (output > 0u) light = record[2u * (BUNDLE_FIRST + output - 1u) + 1u].xyz;
#endif
  return light;
}

// Work-item i: what entry i has received from the direction that was exchanged last (L_x cosθ of equation 4, before
// f_r is known). before: sums of the batch up to then.
__kernel void receive_history(uint count, HistoryStep history_step, __global const uint* restrict list,
                              __global const float4* restrict records, __global float4* restrict before,
                              __global float4* restrict history) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const __global float4* record = records + (size_t)list[i] * BUNDLE_RECORD;
  for (uint k = 0u; k < BUNDLE_REFLECTED; ++k) {
    const size_t own = (size_t)k * count + i;
    const float4 now = (float4)(history_input(record, k), record[1].w);
    const float4 old = history_step.first ? (float4)(0.0f) : before[own];
    history[(size_t)history_step.index * BUNDLE_REFLECTED * count + own] = now - old;
    before[own] = now;
  }
}
