// SPDX-License-Identifier: Apache-2.0
// Which triangle touches which voxel (conservative: Schwarz and Seidel, "Fast Parallel Surface and Solid Voxelization
// on GPUs", 2010): counted, then written triangle by triangle. A triangle is followed column by column along the axis
// where its plane is flattest, so that the work is in proportion to its area, not to its box.
#include "lucarium/shared/scene_types.h"
#include "voxel_abuffer/compared/voxel_keys.clh"
#include "voxel_abuffer/structure/touches.clh"

// Rounding of a normal's component, over the square of the longest edge.
#define COMPARED_NORMAL_ERROR 2.4e-7f

// Where a voxel's centre, projected along an axis, must lie for its square to touch the triangle's projection: behind
// none of three edges, moved outwards. Lane i: the edge from corner i on.
typedef struct ComparedEdges {
  float4 x, y, offset;
} ComparedEdges;

// In voxels, from the first voxel of its box on.
typedef struct ComparedTriangle {
  int4 first, size;        // first voxel, and how many more there are along each axis
  uint axis;               // of the columns
  float4 anchor;           // a corner
  float2 slope;            // depth per column
  float half_range;        // depth that the plane passes within half a column, rounding included
  ComparedEdges edges[3];  // along the columns' axis, the next one, and the one after that
  bool possible;
} ComparedTriangle;

static float compared_at(float4 v, uint axis) { return axis == 0u ? v.x : axis == 1u ? v.y : v.z; }
static int compared_int_at(int4 v, uint axis) { return axis == 0u ? v.x : axis == 1u ? v.y : v.z; }

static uint compared_largest(float4 v) { return v.x >= v.y && v.x >= v.z ? 0u : v.y >= v.z ? 1u : 2u; }

static ComparedEdges compared_edges(const float4* corners, float4 n, uint axis, float half_edge) {
  const uint x = abuffer_axis_x(axis), y = abuffer_axis_y(axis);
  const float4 px = (float4)(compared_at(corners[0], x), compared_at(corners[1], x), compared_at(corners[2], x), 0.0f);
  const float4 py = (float4)(compared_at(corners[0], y), compared_at(corners[1], y), compared_at(corners[2], y), 0.0f);
  const float turn = compared_at(n, axis) >= 0.0f ? 1.0f : -1.0f;
  ComparedEdges edges;
  edges.x = (py - py.yzxw) * turn;
  edges.y = (px.yzxw - px) * turn;
  edges.offset = (fabs(edges.x) + fabs(edges.y)) * half_edge - edges.x * px - edges.y * py;
  return edges;
}

static bool compared_touches(const ComparedEdges* edges, float x, float y) {
  const float4 inside = edges->x * x + edges->y * y + edges->offset;
  return fmin(inside.x, fmin(inside.y, inside.z)) >= 0.0f;
}

static ComparedTriangle compared_load(__global const Vertex* vertices, Triangle triangle, const AbufferGrid* grid,
                                      float pad) {
  // Find the voxels of its box.
  ComparedTriangle t;
  float4 corners[3];
  corners[0] = abuffer_position(grid, vertices[triangle.v0].position);
  corners[1] = abuffer_position(grid, vertices[triangle.v1].position);
  corners[2] = abuffer_position(grid, vertices[triangle.v2].position);
  const float4 low = fmin(corners[0], fmin(corners[1], corners[2])) - pad;
  const float4 high = fmax(corners[0], fmax(corners[1], corners[2])) + pad;
  const float4 sum = corners[0] + corners[1] + corners[2];  // fmin hides NaN
  t.possible = fabs(sum.x) + fabs(sum.y) + fabs(sum.z) < 1e15f;
  t.first = abuffer_clamped_voxel(grid, low);
  t.size = abuffer_clamped_voxel(grid, high) - t.first;
  // Move the corners into units of voxels, from the box's first on.
  const float per_voxel = 1.0f / (float)grid->voxels.w;
  for (uint i = 0u; i < 3u; ++i) {
    corners[i] = corners[i] * per_voxel - convert_float4(t.first);
    corners[i].w = 0.0f;
  }
  t.anchor = corners[0];

  // Follow it along the axis where its plane is flattest.
  const float4 ab = corners[1] - corners[0], ac = corners[2] - corners[0], bc = ac - ab;
  const float4 n = (float4)(cross(ab.xyz, ac.xyz), 0.0f);
  t.axis = compared_largest(fabs(n));
  const float square = fmax(dot(ab, ab), fmax(dot(ac, ac), dot(bc, bc))), largest = fabs(compared_at(n, t.axis));
  // The normal of a needle is rounding error: all depths of its box, in columns along its longest side.
  const bool needle = !(largest > 1e-5f * square);
  if (needle) t.axis = compared_largest(high - low);
  const float scale = needle ? 0.0f : 1.0f / compared_at(n, t.axis);
  t.slope = -(float2)(compared_at(n, abuffer_axis_x(t.axis)), compared_at(n, abuffer_axis_y(t.axis))) * scale;
  const float error = 2.0f * COMPARED_NORMAL_ERROR * square * fabs(scale) * sqrt(square);
  const float steepness = fabs(t.slope.x) + fabs(t.slope.y), margin = pad * per_voxel;
  t.half_range = needle ? INFINITY : 0.5f * steepness + margin * (1.0f + steepness) + error;
  // Its edges, projected along all three axes.
  t.edges[0] = compared_edges(corners, n, t.axis, 0.5f + margin);
  t.edges[1] = compared_edges(corners, n, abuffer_axis_x(t.axis), 0.5f + margin);
  t.edges[2] = compared_edges(corners, n, abuffer_axis_y(t.axis), 0.5f + margin);
  return t;
}

static uint4 compared_voxel_at(const ComparedTriangle* t, int x, int y, int z) {
  const int4 v = (int4)(x, y, z, 0);
  return as_uint4(t->first + (t->axis == 0u ? v.zxyw : t->axis == 1u ? v.yzxw : v));
}

// Visits the voxels that a triangle touches; returns how many. `keys`, `order`, `within`, `triangles`: written from
// `place` on if `write`.
static uint compared_visit(const ComparedTriangle* t, const AbufferGrid* grid, uint triangle, uint place,
                           __global uint* keys, __global uint* order, __global uchar* within, __global uint* triangles,
                           const bool write) {
  if (!t->possible) return 0u;
  const int width = compared_int_at(t->size, abuffer_axis_x(t->axis));
  const int height = compared_int_at(t->size, abuffer_axis_y(t->axis));
  const float deepest = (float)compared_int_at(t->size, t->axis), depth_of_anchor = compared_at(t->anchor, t->axis);
  const float anchor_x = compared_at(t->anchor, abuffer_axis_x(t->axis));
  const float anchor_y = compared_at(t->anchor, abuffer_axis_y(t->axis));
  const uint begin = place;
  for (int y = 0; y <= height; ++y)
    for (int x = 0; x <= width; ++x) {
      // Leave out columns beside the triangle.
      const float center_x = (float)x + 0.5f, center_y = (float)y + 0.5f;
      if (!compared_touches(&t->edges[0], center_x, center_y)) continue;
      // Visit the depths that its plane has in the column, where the other two projections touch it, too.
      const float depth = depth_of_anchor + (center_x - anchor_x) * t->slope.x + (center_y - anchor_y) * t->slope.y;
      const int last = convert_int(clamp(floor(depth + t->half_range), 0.0f, deepest));
      for (int z = convert_int(clamp(floor(depth - t->half_range), 0.0f, deepest)); z <= last; ++z) {
        const float center_z = (float)z + 0.5f;
        if (!compared_touches(&t->edges[1], center_y, center_z) || !compared_touches(&t->edges[2], center_z, center_x))
          continue;
        if (write) {
          const uint4 voxel = compared_voxel_at(t, x, y, z);
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
  const uint count = compared_visit(&t, &grid, i, 0u, 0, 0, 0, 0, false);
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
  compared_visit(&t, &grid, i, compared_first[i], compared_keys, compared_order, compared_within_brick,
                 compared_triangles, true);
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
__kernel void compared_mark_runs(__global const uint* compared_keys, __global const uint* compared_total, uint capacity,
                                 __global uint* compared_begins) {
  const uint i = get_global_id(0);
  if (i >= capacity) return;
  compared_begins[i] = i < compared_total[0] && (i == 0u || compared_keys[i] != compared_keys[i - 1u]);
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
