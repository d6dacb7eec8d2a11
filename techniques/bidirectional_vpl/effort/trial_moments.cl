// SPDX-License-Identifier: Apache-2.0
// First and second moments of a pixel's samples, all layers of the image together.
#include "bidirectional_vpl/shared/settings.h"
#include "lucarium/math.clh"

// moments: sums of the samples [cd/m^2], behind them the sums of their squares.
__kernel void add_trial_moments(__global const float4* restrict sample, uint pixels,
                                __global float4* restrict moments) {
  const uint i = (uint)get_global_id(0);
  if (i >= pixels) return;
  float3 light = (float3)(0.0f);
  for (uint layer = 0u; layer < BIDIRECTIONAL_LAYERS; ++layer) light += sample[layer * pixels + i].xyz;
  moments[i].xyz += light;
  moments[pixels + i].xyz += light * light;
}
