// SPDX-License-Identifier: Apache-2.0
// The state w₀ with which rays begin.
#include "voxel_abuffer/search/parity_ray.clh"

__kernel void start_states(__global const AbufferGrid* abuffer_grid, __global const float* abuffer_triangles,
                           __global const uchar* abuffer_classes, __global const uint* abuffer_parity_start,
                           __global const float* abuffer_parity_depths, __global const uint* abuffer_parity_fragments,
                           __global const Ray* rays, __global const RayEnds* ends, float offset, uint count,
                           __global int* states) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  AbufferContext context;
  context.triangles.nodes = 0;
  context.triangles.blocks = abuffer_triangles;
  context.grid = abuffer_grid[0];
  context.classes = abuffer_classes;
  context.offset = offset;
  context.parity_start = abuffer_parity_start;
  context.parity_depths = abuffer_parity_depths;
  context.parity_fragments = abuffer_parity_fragments;
  abuffer_find_columns(&context);
  AbufferParityRay r;
  AbufferStart start;
  const bool begins = abuffer_begin_parity(&context, rays[i], ends[i], &r, &start);
  states[i] = begins ? abuffer_start_state(&context, ends[i], &start) : 1000;
}
