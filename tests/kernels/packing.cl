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

// By itself, and as one of eight.
kernel void round_up(const global float* in, const uint count, global float* out, global float* of_eight) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  out[i] = half_value(half_above(in[i]));
  const uint8 lanes = (uint8)(0u, 1u, 2u, 3u, 4u, 5u, 6u, 7u);
  const uint8 bits = halves_above8(lanes == (i & 7u) ? (float8)(in[i]) : (float8)(7.0f));
  uint values[8];
  vstore8(bits, 0, values);
  of_eight[i] = half_value(values[i & 7u]);
}
