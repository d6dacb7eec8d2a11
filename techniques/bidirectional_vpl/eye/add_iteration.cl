// SPDX-License-Identifier: Apache-2.0
// Adds a whole sample to the sums of its layers, and begins an empty one.
#include "bidirectional_vpl/shared/settings.h"
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

// Paths with a NaN, infinite or negative contribution.
__kernel void count_bad_paths(__global const EyePathState* restrict states, uint pixels, uint chunk,
                              __global uint* restrict bad) {
  const uint first = (uint)get_global_id(0) * chunk;
  if (first >= pixels) return;
  uint count = 0u;
  for (uint i = first; i < min(first + chunk, pixels); ++i) count += (states[i].flags & EYE_PATH_BAD) != 0u;
  if (count) atomic_add(bad, count);
}
