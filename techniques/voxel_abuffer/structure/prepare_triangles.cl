// SPDX-License-Identifier: Apache-2.0
// What the rasters, the packing and the rays need of each triangle: its class, its plane over the columns of its
// dominant axis, and its corners.
#include "lucarium/shared/scene_types.h"
#include "voxel_abuffer/structure/grid.clh"

static float abuffer_at(float4 v, uint axis) { return axis == 0u ? v.x : axis == 1u ? v.y : v.z; }

// Axis of the largest component.
static uint abuffer_largest(float4 v) { return v.x >= v.y && v.x >= v.z ? 0u : v.y >= v.z ? 1u : 2u; }

// A float product's rounding error is up to 2^-24 of it: the normal's may reach four times that of the squared size.
#define ABUFFER_NORMAL_ERROR 2.4e-7f

// Plane over the columns along `axis`. A needle, whose normal is rounding error, has its whole range of depths in each
// of its columns: along the axis where that is shortest.
static AbufferPlane abuffer_plane(const float4* p, uint* axis) {
  const float4 ab = p[1] - p[0], ac = p[2] - p[0], bc = p[2] - p[1];
  const float4 low = fmin(p[0], fmin(p[1], p[2])), high = fmax(p[0], fmax(p[1], p[2]));
  float4 n = (float4)(ab.y * ac.z - ab.z * ac.y, ab.z * ac.x - ab.x * ac.z, ab.x * ac.y - ab.y * ac.x, 0.0f);
  const float square = fmax(dot(ab.xyz, ab.xyz), fmax(dot(ac.xyz, ac.xyz), dot(bc.xyz, bc.xyz)));
  *axis = abuffer_largest(fabs(n));
  const bool needle = !(fabs(abuffer_at(n, *axis)) > 1e-5f * square);
  if (needle) *axis = abuffer_largest(low - high);
  const uint k = *axis, x = abuffer_axis_x(k), y = abuffer_axis_y(k);
  const float scale = needle ? 0.0f : 1.0f / abuffer_at(n, k);
  const float2 slope = -(float2)(abuffer_at(n, x), abuffer_at(n, y)) * scale;
  const float error = ABUFFER_NORMAL_ERROR * square * fabs(scale) * sqrt(square);
  AbufferPlane plane;
  plane.anchor = (float4)(abuffer_at(p[0], x), abuffer_at(p[0], y), abuffer_at(p[0], k),
                          needle ? INFINITY : 0.5f * (fabs(slope.x) + fabs(slope.y)) + error);
  plane.slope = (float4)(slope, abuffer_at(low, k), abuffer_at(high, k));
  return plane;
}

// Areas of the projections along each axis.
static float4 abuffer_areas(const float4* p) {
  return (float4)(0.5f * fabs(cross((p[1] - p[0]).xyz, (p[2] - p[0]).xyz)), 0.0f);
}

// abuffer_expected_*: fragments of each triangle in the mean over all positions of the grid. A pixel square that
// touches a convex polygon has its centre in the Minkowski sum of both, whose area is the polygon's, its width, its
// height and 1 (pixels); a pixel's centre lies in the projected area. abuffer_component_class: of each component, as
// TriangleClasses::parity has it.
__kernel void abuffer_prepare_triangles(__global const Vertex* scene_vertices, __global const Triangle* scene_triangles,
                                        __global const AbufferGrid* abuffer_grid,
                                        __global const uint* abuffer_component_of,
                                        __global const uchar* abuffer_component_class, __global uchar* abuffer_classes,
                                        __global AbufferPlane* abuffer_planes, __global float* abuffer_triangles,
                                        __global float* abuffer_expected_exact,
                                        __global float* abuffer_expected_parity) {
  const uint i = get_global_id(0);
  const AbufferGrid grid = abuffer_grid[0];
  if (i >= grid.triangles) return;
  const Triangle triangle = scene_triangles[i];
  const float4 corners[3] = {scene_vertices[triangle.v0].position, scene_vertices[triangle.v1].position,
                             scene_vertices[triangle.v2].position};
  // Keep the corners, in world space; p: in grid coordinates.
  __global float* words = abuffer_triangles + i * ABUFFER_TRIANGLE_WORDS;
  float4 p[3];
  for (uint k = 0u; k < 3u; ++k) {
    vstore3(corners[k].xyz, k, words);
    p[k] = abuffer_position(&grid, corners[k]);
  }
  ((__global uint*)words)[9] = i;
  // Compute the plane over the columns.
  uint axis;
  const AbufferPlane plane = abuffer_plane(p, &axis);
  abuffer_planes[i] = plane;
  // Choose the class: absent, parity, or exact along the dominant axis.
  const uchar parity = abuffer_component_class[abuffer_component_of[i]];
  if (parity == ABUFFER_ABSENT) {
    abuffer_classes[i] = 0;
    abuffer_expected_exact[i] = abuffer_expected_parity[i] = 0.0f;
    return;
  }
  abuffer_classes[i] = parity ? parity : (uchar)ABUFFER_EXACT(axis);
  // Expect fragments.
  const float4 areas = abuffer_areas(p), size = fmax(p[0], fmax(p[1], p[2])) - fmin(p[0], fmin(p[1], p[2]));
  const float all = areas.x + areas.y + areas.z;
  const float touched =
      abuffer_at(areas, axis) + abuffer_at(size, abuffer_axis_x(axis)) + abuffer_at(size, abuffer_axis_y(axis)) + 1.0f;
  abuffer_expected_exact[i] = parity || !isfinite(touched) ? 0.0f : touched;
  abuffer_expected_parity[i] = parity && isfinite(all) ? all : 0.0f;
}
