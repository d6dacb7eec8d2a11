// SPDX-License-Identifier: Apache-2.0
// What the cells of a line have received: means over their pixels.
#include "virtual_light_field/tiles/film_cells.clh"

// Work-item i: cell first_cell + i. incoming: RGB9E5 times scale; FIELD_NO_CELL where no ray came.
__kernel void average_line(uint count, uint first_cell, float scale, __global float4* restrict received,
                           __global uint* restrict incoming) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const float4 sum = received[i];
  received[i] = (float4)(0.0f);
  incoming[first_cell + i] = sum.w > 0.0f ? pack_cell(sum.xyz * (scale / sum.w)) : FIELD_NO_CELL;
}

// The same after a survey, whose sums are distances.
__kernel void clear_survey(uint count, __global float* restrict distances) {
  const uint i = get_global_id(0);
  if (i < count) distances[i] = 0.0f;
}
