// SPDX-License-Identifier: Apache-2.0
// Adds a whole sample to the sums of its layers, and begins an empty one.
#include "bidirectional_vpl/eye/eye_path.clh"
#include "lucarium/services/layer_sums/layer_sums.clh"

__kernel void clear_sample(__global float4* restrict sample, uint count, uint slice_base) {
  const uint i = slice_base + (uint)get_global_id(0);
  if (i < count) sample[i] = (float4)(0.0f);
}

// Layer `layer` of the sample.
__kernel void add_layer(__global const float4* restrict sample, uint layer, uint pixels,
                        __global float4* restrict sums) {
  const uint i = (uint)get_global_id(0);
  if (i >= pixels) return;
  sums[i] = add_sample(sums[i], sample[layer * pixels + i].xyz);
}
