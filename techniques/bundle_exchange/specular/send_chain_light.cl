// SPDX-License-Identifier: Apache-2.0
// What texel sides send by what their chains have found.
#include "bundle_exchange/base/exchange_layout.clh"

// What listed texel sides, both halves where they have two, send towards this direction: diffuse and found by their
// chains.
__kernel void apply_contributions(uint count, uint sides, uint half_count, __global const uint* restrict list,
                                  __global const float4* restrict diffuse, __global const float4* restrict contribution,
                                  __global float4* restrict records) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  for (uint side = list[i]; side < half_count; side += sides)
    for (uint k = 0u; k < BUNDLE_REFLECTED; ++k) {
      __global float4* send = records + (size_t)side * BUNDLE_RECORD + 2u * (BUNDLE_FIRST + k);
      (*send).xyz =
          diffuse[(size_t)side * BUNDLE_REFLECTED + k].xyz + contribution[(size_t)i * BUNDLE_REFLECTED + k].xyz;
    }
}
