// SPDX-License-Identifier: Apache-2.0
// The end of a bounce that was computed alone (interleave=pingpong).
#include "bundle_exchange/base/exchange_layout.clh"

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
