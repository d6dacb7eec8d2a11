// SPDX-License-Identifier: Apache-2.0
// Clamped widths of lobes, and joint densities.
#include "bidirectional_vpl/base/clamped_roughness.clh"

// inputs[i]: width alpha and 1 / exponent, density, m, density of the other side.
__kernel void clamp_lobes(uint count, __global const float4* restrict inputs, __global float4* restrict outputs) {
  const uint i = (uint)get_global_id(0);
  if (i >= count) return;
  const float4 in = inputs[i];
  outputs[i] = (float4)(clamped_exponent(1.0f / in.x, in.y, in.z), clamped_alpha(in.x, in.y, in.z),
                        joint_density(in.y, in.w), joint_density(in.y, INFINITY));
}
