// SPDX-License-Identifier: Apache-2.0
// Fragment lists of LayeredRaster into the structure's own, in the order of voxel columns.
#include "lucarium/shared/layered_raster.h"
#include "voxel_abuffer/structure/intervals.clh"

// The lists of an axis begin where those of the axis before end. `first`: of abuffer_counts.
__kernel void abuffer_add_base(__global const uint* pixel_start, uint pixels, uint axis, uint first,
                               __global uint* abuffer_counts) {
  if (axis == 0u) abuffer_counts[first] = 0u;
  abuffer_counts[first + axis + 1u] = abuffer_counts[first + axis] + pixel_start[pixels];
}

// One row of voxels per work-item. Copies nothing where it would not fit: the host makes room and builds again. LEAVE:
// what is done behind each voxel.
#define ABUFFER_PACK(COPY, LEAVE)                                                                  \
  const AbufferGrid grid = abuffer_grid[0];                                                        \
  const uint edge = grid.voxels.w, columns = abuffer_component(grid.voxels, abuffer_axis_x(axis)); \
  const uint rows = abuffer_component(grid.voxels, abuffer_axis_y(axis)), row = DEALT_ROW;         \
  const uint width = columns * edge;                                                               \
  if (row >= rows || abuffer_counts[first + axis + 1u] > capacity) return;                         \
  uint place = abuffer_counts[first + axis] + pixel_start[row * edge * width];                     \
  __global uint* start = abuffer_start + axis * grid.bricks.w + row * columns * edge * edge;       \
  for (uint voxel = 0u; voxel < columns; ++voxel) {                                                \
    for (uint y = row * edge; y < (row + 1u) * edge; ++y)                                          \
      for (uint x = voxel * edge; x < (voxel + 1u) * edge; ++x) {                                  \
        *start++ = place;                                                                          \
        const uint begin = pixel_start[y * width + x], end = pixel_start[y * width + x + 1u];      \
        for (uint i = begin; i < end; ++i, ++place) COPY                                           \
      }                                                                                            \
    LEAVE                                                                                          \
  }                                                                                                \
  if (row + 1u == rows) *start = place

// Lists are ordered by triangle, as abuffer_fill_touched() leaves them.
__kernel void abuffer_pack_exact(__global const AbufferGrid* abuffer_grid, __global const uint* pixel_start,
                                 __global const LayeredFragment* fragments, __global const AbufferPlane* abuffer_planes,
                                 __global const uint* abuffer_counts, uint axis, uint first, uint capacity,
                                 __global uint* abuffer_start, __global uint* abuffer_depths,
                                 __global uint* abuffer_fragments, DEALT_ROW_PARAMETER) {
  ABUFFER_PACK({
    const uint triangle = fragments[i].triangle & ~LAYERED_AWAY;
    const AbufferPlane plane = abuffer_planes[triangle];
    const uint interval = abuffer_interval(&plane, (float)x + 0.5f, (float)y + 0.5f, grid.slack);
    uint at = place;
    for (; at > start[-1] && abuffer_fragments[at - 1u] > triangle; --at) {
      abuffer_fragments[at] = abuffer_fragments[at - 1u];
      abuffer_depths[at] = abuffer_depths[at - 1u];
    }
    abuffer_depths[at] = interval;
    abuffer_fragments[at] = triangle;
  }, );
}

// Lists come sorted by depth. abuffer_facing, for the average normal of a voxel (Hu et al. 2014, section 3.1): per
// voxel and axis, its fragments, and those that face against the axis less those along it. They are the sums of |n| and
// n over the voxel's surface in units of pixels (cleared before), and are gathered for a column of voxels at a time.
__kernel void abuffer_pack_parity(__global const AbufferGrid* abuffer_grid, __global const uint* pixel_start,
                                  __global const LayeredFragment* fragments, __global const uchar* abuffer_classes,
                                  __global const uint* abuffer_counts, uint axis, uint first, uint capacity,
                                  __global uint* abuffer_start, __global float* abuffer_depths,
                                  __global uint* abuffer_fragments, __global int2* abuffer_facing,
                                  DEALT_ROW_PARAMETER) {
  const float corner = axis == 0u   ? abuffer_grid[0].corner.x
                       : axis == 1u ? abuffer_grid[0].corner.y
                                    : abuffer_grid[0].corner.z;
  const uint deepest = abuffer_component(abuffer_grid[0].voxels, axis) - 1u;
  int2 facing[ABUFFER_GRID_VOXELS];
  for (uint z = 0u; z <= deepest; ++z) facing[z] = (int2)(0);
  uint lowest = deepest, highest = 0u;
  ABUFFER_PACK(
      {
        const LayeredFragment f = fragments[i];
        const float depth = (f.depth - corner) * grid.corner.w;
        abuffer_depths[place] = depth;
        const uchar open = abuffer_classes[f.triangle & ~LAYERED_AWAY] & ABUFFER_OPEN;
        abuffer_fragments[place] = f.triangle | (open ? ABUFFER_OPEN_FRAGMENT : 0u);
        const uint z = min((uint)fmax(depth / (float)edge, 0.0f), deepest);
        lowest = min(lowest, z);
        highest = max(highest, z);
        facing[z] += (int2)(1, f.triangle & LAYERED_AWAY ? -1 : 1);
      },
      {
        for (uint z = lowest; z <= highest; ++z) {
          const uint index = abuffer_voxel(grid.bricks, abuffer_voxel_of(axis, voxel, row, z));
          abuffer_facing[3u * index + axis] = facing[z];
          facing[z] = (int2)(0);
        }
        lowest = deepest;
        highest = 0u;
      });
}
