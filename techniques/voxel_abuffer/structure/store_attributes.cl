// SPDX-License-Identifier: Apache-2.0
// Attributes beside every fragment for parity, as Hu et al. 2014 (section 3.1) store them, so that rays need not look
// at triangles. Compiled without -cl-mad-enable, as the search is: both then round alike.
#include "lucarium/shared/scene_types.h"
#include "voxel_abuffer/structure/fragment_point.clh"

// One row of voxel columns per work-item. Writes nothing where fragments had no room: the host makes some, and builds
// again.
__kernel void abuffer_store_attributes(__global const AbufferGrid* abuffer_grid,
                                       __global const Triangle* scene_triangles,
                                       __global const Instance* scene_instances,
                                       __global const float* abuffer_triangles, __global const uint* abuffer_counts,
                                       uint axis, uint first, uint capacity, __global const uint* abuffer_start,
                                       __global const float* abuffer_depths, __global const uint* abuffer_fragments,
                                       __global AbufferAttributes* abuffer_attributes, DEALT_ROW_PARAMETER) {
  const AbufferGrid grid = abuffer_grid[0];
  const uint edge = grid.voxels.w, columns = abuffer_component(grid.voxels, abuffer_axis_x(axis)) * edge * edge;
  const uint row = DEALT_ROW;
  if (row >= abuffer_component(grid.voxels, abuffer_axis_y(axis)) || abuffer_counts[first + axis + 1u] > capacity)
    return;
  __global const uint* start = abuffer_start + axis * grid.bricks.w;
  for (uint column = row * columns; column < (row + 1u) * columns; ++column)
    for (uint i = start[column]; i < start[column + 1u]; ++i) {
      const uint triangle = abuffer_fragments[i] & ABUFFER_TRIANGLE;
      const float3 point = abuffer_fragment_point(grid.voxels, axis, column, abuffer_depths[i]);
      const float2 uv = abuffer_fragment_barycentrics(&grid, abuffer_triangles, triangle, point);
      const float3 n = abuffer_triangle_normal(abuffer_triangles, triangle);
      AbufferAttributes attributes;
      attributes.u = uv.x;
      attributes.v = uv.y;
      attributes.normal_x = n.x;
      attributes.normal_y = n.y;
      attributes.normal_z = n.z;
      attributes.material = scene_instances[scene_triangles[triangle].instance].material;
      abuffer_attributes[i] = attributes;
    }
}
