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

// Coordinates of the cells that a pixel of a voxel covers: first and last in bits 0–7 and 8–15.
static uint abuffer_cells_of_pixel(uint pixel, uint edge) {
  return (8u * pixel / edge) | ((8u * pixel + 7u) / edge) << 8;
}

// Cells (bits 8 y + x) of a column's cross section.
static ulong abuffer_cell_section(uint x, uint y) {
  const ulong row = (2ul << (x >> 8)) - (1ul << (x & 255u));
  ulong section = 0ul;
  for (uint i = y & 255u; i <= y >> 8; ++i) section |= row << (8u * i);
  return section;
}

// Marks the cells of one depth interval, in the slices across `axis` only: abuffer_turn_cells() makes the others.
static void abuffer_mark_cells(__global const AbufferGrid* grid, __global const uint* voxels, __global ulong* cells,
                               uint axis, uint voxel_x, uint voxel_y, ulong section, uint interval) {
  const uint edge = grid->voxels.w, steps = 2u * edge;  // a cell's of ABUFFER_DEPTH_STEPS
  const uint last_slab = 8u * abuffer_component(grid->voxels, axis) - 1u;
  const uint first = min((interval & 0xffffu) / steps, last_slab);
  const uint last = min(((uint)ABUFFER_DEPTH_LAST - (interval >> 16)) / steps, last_slab);
  for (uint slab = first; slab <= last; ++slab) {
    const uint word = voxels[abuffer_voxel(grid->bricks, abuffer_voxel_of(axis, voxel_x, voxel_y, slab >> 3))];
    if (!(word & ABUFFER_EXACT(axis))) continue;  // near it only
    const uint block = (word >> ABUFFER_CELLS_SHIFT) + popcount(word & (ABUFFER_EXACT(axis) - 1u));
    cells[block * ABUFFER_CELL_WORDS + 8u * axis + (slab & 7u)] |= section;
  }
}

__kernel void abuffer_pack_exact(__global const AbufferGrid* abuffer_grid, __global const uint* pixel_start,
                                 __global const LayeredFragment* fragments, __global const AbufferPlane* abuffer_planes,
                                 __global const uint* abuffer_counts, uint axis, uint first, uint capacity,
                                 __global const uint* abuffer_voxels, uint cell_capacity, __global uint* abuffer_start,
                                 __global uint* abuffer_depths, __global uint* abuffer_fragments,
                                 __global ulong* abuffer_cells) {
  if (abuffer_counts[ABUFFER_COUNT_CELLS] > cell_capacity) return;
  ABUFFER_PACK({
    const uint triangle = fragments[i].triangle & ~LAYERED_AWAY;
    const AbufferPlane plane = abuffer_planes[triangle];
    const uint interval = abuffer_interval(&plane, (float)x + 0.5f, (float)y + 0.5f, grid.slack);
    abuffer_depths[place] = interval;
    abuffer_fragments[place] = triangle;
    const ulong section = abuffer_cell_section(abuffer_cells_of_pixel(x - voxel * edge, edge),
                                               abuffer_cells_of_pixel(y - row * edge, edge));
    abuffer_mark_cells(abuffer_grid, abuffer_voxels, abuffer_cells, axis, voxel, row, section, interval);
  });
}

// abuffer_facing: per voxel and axis, its fragments, and those that face against the axis less those along it. They are
// the sums of |n| and n over the voxel's surface in units of pixels (cleared before).
__kernel void abuffer_pack_parity(__global const AbufferGrid* abuffer_grid, __global const uint* pixel_start,
                                  __global const LayeredFragment* fragments, __global const uint* abuffer_counts,
                                  uint axis, uint first, uint capacity, __global uint* abuffer_start,
                                  __global float* abuffer_depths, __global uint* abuffer_fragments,
                                  __global int2* abuffer_facing) {
  const float corner = axis == 0u   ? abuffer_grid[0].corner.x
                       : axis == 1u ? abuffer_grid[0].corner.y
                                    : abuffer_grid[0].corner.z;
  ABUFFER_PACK({
    const LayeredFragment f = fragments[i];
    const float depth = (f.depth - corner) * grid.corner.w;
    abuffer_depths[place] = depth;
    abuffer_fragments[place] = f.triangle;
    const uint z = min((uint)fmax(depth / (float)edge, 0.0f), abuffer_component(grid.voxels, axis) - 1u);
    const uint index = abuffer_voxel(grid.bricks, abuffer_voxel_of(axis, voxel, row, z));
    abuffer_facing[3u * index + axis] += (int2)(1, f.triangle & LAYERED_AWAY ? -1 : 1);
  });
}
