// SPDX-License-Identifier: Apache-2.0
#include "lucarium/packing.clh"

kernel void round_trip_directions(const global float4* in, const uint count, const uint bits, global float4* out) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const float3 n = in[i].xyz;
  out[i] = (float4)(bits == 32u ? unpack_direction(pack_direction(n)) : unpack_normal(pack_normal(n)), 0.0f);
}

// w: bits of the packed colour.
kernel void round_trip_colors(const global float4* in, const uint count, global float4* out) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const uint packed = pack_rgb9e5(in[i].xyz);
  out[i] = (float4)(unpack_rgb9e5(packed), as_float(packed));
}

kernel void round_up(const global float* in, const uint count, global float* out) {
  const uint i = get_global_id(0);
  if (i < count) out[i] = half_value(half_above(in[i]));
}
