// SPDX-License-Identifier: Apache-2.0
// What the cells of a line have received: means over their pixels.
#include "virtual_light_field/tiles/subfield_cells.clh"

// Work-item i: cell first_cell + i. incoming: RGB9E5 times scale; FIELD_NO_CELL where no ray came.
__kernel void average_line(uint count, uint first_cell, float scale, __global float4* restrict received,
                           __global uint* restrict incoming) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const float4 sum = received[i];
  received[i] = (float4)(0.0f);
  incoming[first_cell + i] = sum.w > 0.0f ? pack_cell(sum.xyz * (scale / sum.w)) : FIELD_NO_CELL;
}

// The same of sums of perturbed lines (perturbed_ends.clh), whose radiance is scaled.
__kernel void average_perturbed(uint count, uint first_cell, __global uint* restrict received,
                                __global uint* restrict incoming) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  __global uint* sums = received + (size_t)FIELD_FIXED_WORDS * i;
  float sum[4];
  for (uint k = 0u; k < 4u; ++k) {
    sum[k] = (float)((ulong)sums[2u * k + 1u] << 32 | sums[2u * k]);
    sums[2u * k] = sums[2u * k + 1u] = 0u;
  }
  incoming[first_cell + i] = sum[3] > 0.0f ? pack_cell((float3)(sum[0], sum[1], sum[2]) / sum[3]) : FIELD_NO_CELL;
}

// The same after a survey, whose sums are distances.
__kernel void clear_survey(uint count, __global float* restrict distances) {
  const uint i = get_global_id(0);
  if (i < count) distances[i] = 0.0f;
}
