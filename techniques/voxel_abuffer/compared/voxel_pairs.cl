// SPDX-License-Identifier: Apache-2.0
// Which triangle touches which voxel: counted, then written triangle by triangle. A triangle is followed column by
// column along the axis where its plane is flattest, so that the work is in proportion to its area, not to its box.
#include "lucarium/shared/scene_types.h"
#include "voxel_abuffer/compared/voxel_keys.clh"
#include "voxel_abuffer/structure/touches.clh"

// Rounding of a normal's component, over the square of the longest edge.
#define COMPARED_NORMAL_ERROR 2.4e-7f

typedef struct ComparedTriangle {
  float4 corners[3];  // grid coordinates
  int4 first, last;   // voxels of its box
  uint axis;          // of the columns
  float2 slope;       // voxels of depth per voxel across
  float half_range;   // depth that the plane passes within half a column, rounding included [voxels]
  bool possible;
} ComparedTriangle;

static float compared_at(float4 v, uint axis) { return axis == 0u ? v.x : axis == 1u ? v.y : v.z; }
static int compared_int_at(int4 v, uint axis) { return axis == 0u ? v.x : axis == 1u ? v.y : v.z; }

static ComparedTriangle compared_load(__global const Vertex* vertices, Triangle triangle, const AbufferGrid* grid,
                                      float pad) {
  ComparedTriangle t;
  t.corners[0] = abuffer_position(grid, vertices[triangle.v0].position);
  t.corners[1] = abuffer_position(grid, vertices[triangle.v1].position);
  t.corners[2] = abuffer_position(grid, vertices[triangle.v2].position);
  for (uint i = 0u; i < 3u; ++i) t.corners[i].w = 0.0f;
  const float4 low = fmin(t.corners[0], fmin(t.corners[1], t.corners[2])) - pad;
  const float4 high = fmax(t.corners[0], fmax(t.corners[1], t.corners[2])) + pad;
  const float4 sum = t.corners[0] + t.corners[1] + t.corners[2];  // fmin hides NaN
  t.possible = fabs(sum.x) + fabs(sum.y) + fabs(sum.z) < 1e15f;
  t.first = abuffer_clamped_voxel(grid, low);
  t.last = abuffer_clamped_voxel(grid, high);

  const float4 ab = t.corners[1] - t.corners[0], ac = t.corners[2] - t.corners[0], bc = ac - ab;
  const float4 n = (float4)(cross(ab.xyz, ac.xyz), 0.0f), size = fabs(n);
  t.axis = size.x >= size.y && size.x >= size.z ? 0u : size.y >= size.z ? 1u : 2u;
  const float square = fmax(dot(ab, ab), fmax(dot(ac, ac), dot(bc, bc))), largest = compared_at(size, t.axis);
  // The normal of a needle is rounding error: all depths of its box, in the columns across its longest side.
  const bool needle = !(largest > 1e-5f * square);
  if (needle) {
    const float4 extent = high - low;
    t.axis = extent.x >= extent.y && extent.x >= extent.z ? 0u : extent.y >= extent.z ? 1u : 2u;
  }
  const float scale = needle ? 0.0f : 1.0f / compared_at(n, t.axis);
  t.slope = -(float2)(compared_at(n, abuffer_axis_x(t.axis)), compared_at(n, abuffer_axis_y(t.axis))) * scale;
  const float error = 2.0f * COMPARED_NORMAL_ERROR * square * fabs(scale) * sqrt(square), edge = (float)grid->voxels.w;
  const float steepness = fabs(t.slope.x) + fabs(t.slope.y);
  t.half_range = needle ? INFINITY : 0.5f * steepness + (pad * (1.0f + steepness) + error) / edge + 1e-3f;
  return t;
}

// Least and greatest voxel of a column, in the order of depth.
static int2 compared_depths(const ComparedTriangle* t, int x, int y, float edge) {
  const int first = compared_int_at(t->first, t->axis), last = compared_int_at(t->last, t->axis);
  const float4 a = t->corners[0] / edge;
  const float depth = compared_at(a, t->axis) +
                      ((float)x + 0.5f - compared_at(a, abuffer_axis_x(t->axis))) * t->slope.x +
                      ((float)y + 0.5f - compared_at(a, abuffer_axis_y(t->axis))) * t->slope.y;
  const float near = clamp(floor(depth - t->half_range), (float)first, (float)last);
  const float far = clamp(floor(depth + t->half_range), (float)first, (float)last);
  return convert_int2((float2)(near, far));
}

static uint4 compared_voxel_at(uint axis, int x, int y, int z) {
  const uint4 v = (uint4)((uint)x, (uint)y, (uint)z, 0u);
  return axis == 0u ? v.zxyw : axis == 1u ? v.yzxw : v;
}

// Visits the voxels that a triangle touches; returns how many. `keys`, `order`, `within`, `triangles`: written from
// `place` on if `write`.
static uint compared_visit(const ComparedTriangle* t, const AbufferGrid* grid, float pad, uint triangle, uint place,
                           __global uint* keys, __global uint* order, __global uchar* within, __global uint* triangles,
                           const bool write) {
  if (!t->possible) return 0u;
  const float edge = (float)grid->voxels.w, half_edge = 0.5f * edge + pad;
  const uint x_axis = abuffer_axis_x(t->axis), y_axis = abuffer_axis_y(t->axis);
  // Along one axis only it touches all that its bounds do.
  const int lines = (t->first.x != t->last.x) + (t->first.y != t->last.y) + (t->first.z != t->last.z);
  const uint begin = place;
  for (int y = compared_int_at(t->first, y_axis); y <= compared_int_at(t->last, y_axis); ++y)
    for (int x = compared_int_at(t->first, x_axis); x <= compared_int_at(t->last, x_axis); ++x) {
      const int2 depths = compared_depths(t, x, y, edge);
      for (int z = depths.x; z <= depths.y; ++z) {
        const uint4 voxel = compared_voxel_at(t->axis, x, y, z);
        const float4 center = (convert_float4(voxel) + (float4)(0.5f, 0.5f, 0.5f, 0.0f)) * edge;
        if (lines >= 2 && !abuffer_touches(t->corners, center, half_edge)) continue;
        if (write) {
          keys[place] = compared_brick(grid->bricks, voxel);
          order[place] = place;
          within[place] = (uchar)compared_within(voxel);
          triangles[place] = triangle;
        }
        ++place;
      }
    }
  return place - begin;
}

__kernel void compared_count_pairs(__global const Vertex* scene_vertices, __global const Triangle* scene_triangles,
                                   __global const AbufferGrid* compared_grid, float pad, __global uint* compared_counts,
                                   __global float* compared_float_counts) {
  const uint i = get_global_id(0);
  const AbufferGrid grid = compared_grid[0];
  if (i >= grid.triangles) return;
  const ComparedTriangle t = compared_load(scene_vertices, scene_triangles[i], &grid, pad + grid.slack);
  const uint count = compared_visit(&t, &grid, pad + grid.slack, i, 0u, 0, 0, 0, 0, false);
  compared_counts[i] = count;
  compared_float_counts[i] = (float)count;
}

// compared_first: pairs of the triangles before.
__kernel void compared_write_pairs(__global const Vertex* scene_vertices, __global const Triangle* scene_triangles,
                                   __global const AbufferGrid* compared_grid, float pad,
                                   __global const uint* compared_first, __global uint* compared_keys,
                                   __global uint* compared_order, __global uchar* compared_within_brick,
                                   __global uint* compared_triangles) {
  const uint i = get_global_id(0);
  const AbufferGrid grid = compared_grid[0];
  if (i >= grid.triangles) return;
  const ComparedTriangle t = compared_load(scene_vertices, scene_triangles[i], &grid, pad + grid.slack);
  compared_visit(&t, &grid, pad + grid.slack, i, compared_first[i], compared_keys, compared_order,
                 compared_within_brick, compared_triangles, true);
}

// Keys behind the last pair, larger than all.
__kernel void compared_pad_keys(__global const uint* compared_total, uint capacity, uint last,
                                __global uint* compared_keys, __global uint* compared_order) {
  const uint i = compared_total[0] + get_global_id(0);
  if (i >= capacity) return;
  compared_keys[i] = last;
  compared_order[i] = 0u;
}

// Whether a run of equal keys begins.
__kernel void compared_mark_runs(__global const uint* compared_keys, __global const uint* compared_total, uint shift,
                                 uint capacity, __global uint* compared_begins) {
  const uint i = get_global_id(0);
  if (i >= capacity) return;
  compared_begins[i] =
      i < compared_total[0] && (i == 0u || compared_keys[i] >> shift != compared_keys[i - 1u] >> shift);
}

// A bit for each occupied voxel of a brick. compared_brick_count[0]: bricks.
__kernel void compared_fill_bricks(__global const uint* compared_keys, __global const uint* compared_order,
                                   __global const uchar* compared_within_brick, __global const uint* compared_total,
                                   __global const uint* compared_brick_start, __global const uint* compared_brick_count,
                                   uint capacity, __global uint* compared_brick_keys,
                                   __global ulong* compared_brick_masks, __global uint* compared_brick_voxels) {
  const uint b = get_global_id(0), count = compared_brick_count[0];
  if (b >= min(count, capacity)) return;
  const uint begin = compared_brick_start[b], end = b + 1u < count ? compared_brick_start[b + 1u] : compared_total[0];
  ulong mask = 0ul;
  for (uint i = begin; i < end; ++i) mask |= 1ul << compared_within_brick[compared_order[i]];
  compared_brick_keys[b] = compared_keys[begin];
  compared_brick_masks[b] = mask;
  compared_brick_voxels[b] = (uint)popcount(mask);
}
