// SPDX-License-Identifier: Apache-2.0
// Fragment lists of LayeredRaster into the structure's own, in the order of voxel columns.
#include "lucarium/shared/layered_raster.h"
#include "voxel_abuffer/structure/grid.clh"

// The lists of an axis begin where those of the axis before end. `first`: of abuffer_counts.
__kernel void abuffer_add_base(__global const uint* pixel_start, uint pixels, uint axis, uint first,
                               __global uint* abuffer_counts) {
  if (axis == 0u) abuffer_counts[first] = 0u;
  abuffer_counts[first + axis + 1u] = abuffer_counts[first + axis] + pixel_start[pixels];
}

// Depths between which a triangle may lie in a column.
static uint abuffer_interval(const AbufferPlane* plane, float x, float y, float slack) {
  const float depth = plane->anchor.z + (x - plane->anchor.x) * plane->slope.x + (y - plane->anchor.y) * plane->slope.y;
  const float near = fmax(depth - plane->anchor.w, plane->slope.z) - slack;
  const float far = fmin(depth + plane->anchor.w, plane->slope.w) + slack;
  const float first = clamp(floor(near * ABUFFER_DEPTH_STEPS), 0.0f, ABUFFER_DEPTH_LAST);
  const float last = clamp(ceil(far * ABUFFER_DEPTH_STEPS), 0.0f, ABUFFER_DEPTH_LAST);
  return (uint)first | (uint)(ABUFFER_DEPTH_LAST - last) << 16;
}

// What a column's list is copied from and to.
typedef struct AbufferPack {
  __global const LayeredFragment* fragments;
  uint place;  // next to write
} AbufferPack;

// One row of voxels per work-item. Copies nothing where it would not fit: the host makes room and builds again.
#define ABUFFER_PACK(COPY)                                                                         \
  const AbufferGrid grid = abuffer_grid[0];                                                        \
  const uint edge = grid.voxels.w, columns = abuffer_component(grid.voxels, abuffer_axis_x(axis)); \
  const uint rows = abuffer_component(grid.voxels, abuffer_axis_y(axis)), row = get_global_id(0);  \
  const uint width = columns * edge;                                                               \
  if (row >= rows || abuffer_counts[first + axis + 1u] > capacity) return;                         \
  uint place = abuffer_counts[first + axis] + pixel_start[row * edge * width];                     \
  __global uint* start = abuffer_start + axis * grid.bricks.w + row * columns * edge * edge;       \
  for (uint voxel = 0u; voxel < columns; ++voxel)                                                  \
    for (uint y = row * edge; y < (row + 1u) * edge; ++y)                                          \
      for (uint x = voxel * edge; x < (voxel + 1u) * edge; ++x) {                                  \
        *start++ = place;                                                                          \
        const uint begin = pixel_start[y * width + x], end = pixel_start[y * width + x + 1u];      \
        for (uint i = begin; i < end; ++i, ++place) COPY                                           \
      }                                                                                            \
  if (row + 1u == rows) *start = place

__kernel void abuffer_pack_exact(__global const AbufferGrid* abuffer_grid, __global const uint* pixel_start,
                                 __global const LayeredFragment* fragments, __global const AbufferPlane* abuffer_planes,
                                 __global const uint* abuffer_counts, uint axis, uint first, uint capacity,
                                 __global uint* abuffer_start, __global uint* abuffer_depths,
                                 __global uint* abuffer_fragments) {
  ABUFFER_PACK({
    const uint triangle = fragments[i].triangle & ~LAYERED_AWAY;
    const AbufferPlane plane = abuffer_planes[triangle];
    abuffer_depths[place] = abuffer_interval(&plane, (float)x + 0.5f, (float)y + 0.5f, grid.slack);
    abuffer_fragments[place] = triangle;
  });
}

__kernel void abuffer_pack_parity(__global const AbufferGrid* abuffer_grid, __global const uint* pixel_start,
                                  __global const LayeredFragment* fragments, __global const uint* abuffer_counts,
                                  uint axis, uint first, uint capacity, __global uint* abuffer_start,
                                  __global float* abuffer_depths, __global uint* abuffer_fragments) {
  const float corner = axis == 0u   ? abuffer_grid[0].corner.x
                       : axis == 1u ? abuffer_grid[0].corner.y
                                    : abuffer_grid[0].corner.z;
  ABUFFER_PACK({
    abuffer_depths[place] = (fragments[i].depth - corner) * grid.corner.w;
    abuffer_fragments[place] = fragments[i].triangle;
  });
}
