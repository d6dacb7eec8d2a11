// SPDX-License-Identifier: Apache-2.0
// Points spread evenly over surfaces: best candidates in rounds (Mitchell 1991, stratified by area), as Ritschel et al.
// 2009, section 2.1, ask for.
#pragma once
#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

namespace lucarium::micro {

/// One side of a triangle that points shall lie on.
struct SurfaceSide {
  glm::vec3 v0, v1, v2;  ///< counter-clockwise seen from this side
  uint32_t source = 0;   ///< the caller's name for it
  float coverage = 1;    ///< how much of its area is there [1]
  bool back = false;     ///< corners are given counter-clockwise for the other side
};

struct SampledPoint {
  glm::vec3 position{0}, normal{0};
  glm::vec2 weights{0};  ///< barycentric, of v1 and v2
  uint32_t source = 0;
  float area = 0;      ///< of the triangle
  bool solid = false;  ///< nothing but the inside of a solid sees its back (point_visibility.h)
};

struct SampledSurface {
  std::vector<SampledPoint> points;
  double area = 0;  ///< of all sides, coverage included
};

/// Area of all sides, coverage included.
double covered_area(const std::vector<SurfaceSide>& sides);

/// Whether a point of a side with coverage below 1 is there; `weights` as in SampledPoint.
using PointTest = bool (*)(const void* context, uint32_t source, glm::vec2 weights, float random);

/// `count` points (a power of two), in proportion to covered area: every run of count / 2, / 4, … (down to 64) equal
/// parts of the area, taken in Morton order of the triangles, holds the same number of points. The result depends on
/// `seed` alone, not on the number of threads. Without area all points lie on the first side. `test` may be null.
/// `progress`, which may be empty, gets the number of points that are placed. Throws Error{interrupted}.
SampledSurface sample_surface(const std::vector<SurfaceSide>& sides, uint32_t count, uint32_t seed, int threads,
                              PointTest test = nullptr, const void* test_context = nullptr,
                              const std::function<void(uint32_t)>& progress = {});

}  // namespace lucarium::micro
