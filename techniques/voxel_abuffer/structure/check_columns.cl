// SPDX-License-Identifier: Apache-2.0
// Components that parity does not search rightly: those whose fronts and backs do not balance, which have no inside
// after all, and those that share a wall with another one or with themselves, on both sides of which the state is the
// same.
#include "voxel_abuffer/structure/fragment_point.clh"

// Pixels between the two sides of a common wall, besides rounding: the raster snaps corners to 1/256 pixel, so that in
// the columns of its dominant axis a triangle is off by 1/256 pixel at most.
#define ABUFFER_TOUCH 0.0078125f
// Cosine between their normals: other triangles that meet in a column pass through each other.
#define ABUFFER_OPPOSITE -0.9999f

// Whether two triangles look away from each other.
static bool abuffer_are_opposite(__global const float* triangles, uint a, uint b) {
  const float3 n = abuffer_triangle_normal(triangles, a), m = abuffer_triangle_normal(triangles, b);
  return dot(n, m) < ABUFFER_OPPOSITE * length(n) * length(m);
}

// Marks both components of every common wall in the list begin … end; whether there is any.
static bool abuffer_check_walls(__global const float* depths, __global const uint* fragments, uint begin, uint end,
                                float touch, __global const float* triangles, __global const uint* component_of,
                                volatile __global uint* marked) {
  bool any = false;
  for (uint i = begin + 1u; i < end; ++i) {
    if (!(depths[i] - depths[i - 1u] <= touch) || !((fragments[i] ^ fragments[i - 1u]) >> 31)) continue;
    const uint one = fragments[i - 1u] & ABUFFER_TRIANGLE, other = fragments[i] & ABUFFER_TRIANGLE;
    if (!abuffer_are_opposite(triangles, one, other)) continue;
    marked[component_of[one]] = marked[component_of[other]] = 1u;
    any = true;
  }
  return any;
}

// Fragments of lists in which every component is marked: to count for each takes the square of that.
#define ABUFFER_LONG 1024u

// Marks the components of the list begin … end that do not balance by themselves.
static void abuffer_check_balances(__global const uint* fragments, uint begin, uint end,
                                   __global const uint* component_of, volatile __global uint* marked) {
  for (uint i = begin; i < end; ++i) {
    const uint component = component_of[fragments[i] & ABUFFER_TRIANGLE];
    if (end - begin > ABUFFER_LONG) {
      marked[component] = 1u;
      continue;
    }
    int own = 0;
    for (uint j = begin; j < end; ++j)
      if (component_of[fragments[j] & ABUFFER_TRIANGLE] == component) own += fragments[j] >> 31 ? -1 : 1;
    if (own != 0) marked[component] = 1u;
  }
}

// Columns in which fronts and backs do not cancel, of meshes whose seams a deformation opened, and those with common
// walls. abuffer_marked: per component, set to 1; behind them the numbers of such columns.
__kernel void abuffer_check_columns(__global const AbufferGrid* abuffer_grid, __global const uint* abuffer_start,
                                    __global const float* abuffer_depths, __global const uint* abuffer_fragments,
                                    __global const float* abuffer_triangles, __global const uint* abuffer_component_of,
                                    __global const uint* abuffer_counts, uint first, uint capacity, uint components,
                                    volatile __global uint* abuffer_marked) {
  const AbufferGrid grid = abuffer_grid[0];
  const uint column = get_global_id(0), axis = get_global_id(1);
  const uint columns = abuffer_component(grid.voxels, abuffer_axis_x(axis)) *
                       abuffer_component(grid.voxels, abuffer_axis_y(axis)) * grid.voxels.w * grid.voxels.w;
  if (column >= columns || abuffer_counts[first + 3u] > capacity) return;
  const uint begin = abuffer_start[axis * grid.bricks.w + column],
             end = abuffer_start[axis * grid.bricks.w + column + 1u];
  int balance = 0;
  for (uint i = begin; i < end; ++i) balance += abuffer_fragments[i] >> 31 ? -1 : 1;
  if (balance != 0) {
    atomic_inc(abuffer_marked + components);
    abuffer_check_balances(abuffer_fragments, begin, end, abuffer_component_of, abuffer_marked);
  }
  const float touch = ABUFFER_TOUCH + 2.0f * grid.slack;
  if (abuffer_check_walls(abuffer_depths, abuffer_fragments, begin, end, touch, abuffer_triangles, abuffer_component_of,
                          abuffer_marked))
    atomic_inc(abuffer_marked + components + 1u);
}
