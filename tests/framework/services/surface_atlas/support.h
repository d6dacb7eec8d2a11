// SPDX-License-Identifier: Apache-2.0
// What several tests of the surface atlas need: geometry of scenes, random points, and what must hold of every layout.
#pragma once
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "device_fixture.h"
#include "lucarium/scene/builtin/scenes.h"
#include "lucarium/scene/device/degenerate_triangle.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/scene/load/load_scene.h"
#include "lucarium/services/surface_atlas/geometry.h"
#include "lucarium/services/surface_atlas/layout/layout.h"
#include "lucarium/services/surface_atlas/layout/look_up.h"
#include "tolerance.h"

namespace lucarium::test {

inline AtlasGeometry geometry_of(const Scene& scene, bool use_texcoord1 = false) {
  const SceneBuffers buffers(*test_device(), scene);
  return read_atlas_geometry(scene, buffers, use_texcoord1);
}

inline glm::dvec3 corner(const AtlasGeometry& g, uint32_t t, int i) {
  return glm::dvec3(g.positions[g.triangles[t][i]]);
}

inline double area_of(const AtlasGeometry& g, uint32_t t) {
  return 0.5 * glm::length(glm::cross(corner(g, t, 1) - corner(g, t, 0), corner(g, t, 2) - corner(g, t, 0)));
}

inline glm::dvec3 point_on(const AtlasGeometry& g, uint32_t t, float b1, float b2) {
  const glm::dvec3 a = corner(g, t, 0);
  return a + double(b1) * (corner(g, t, 1) - a) + double(b2) * (corner(g, t, 2) - a);
}

/// Area of all reflecting sides [m²].
inline double side_area(const AtlasGeometry& g) {
  double sum = 0;
  for (uint32_t t = 0; t < g.triangles.size(); ++t) sum += area_of(g, t) * (g.two_sided[g.instance[t]] ? 2 : 1);
  return sum;
}

/// Triangles with vertices of their own.
inline AtlasGeometry soup(const std::vector<glm::vec3>& corners, bool two_sided = false) {
  AtlasGeometry g;
  g.positions = corners;
  for (uint32_t i = 0; i + 2 < corners.size(); i += 3) {
    g.triangles.emplace_back(i, i + 1, i + 2);
    g.instance.push_back(0);
    const glm::vec3 n = glm::cross(corners[i + 1] - corners[i], corners[i + 2] - corners[i]);
    g.normals.insert(g.normals.end(), 3, glm::length(n) > 0 ? glm::normalize(n) : glm::vec3(0, 1, 0));
  }
  g.two_sided = {two_sided};
  return g;
}

/// A rectangle of the plane y = 0 that faces up.
inline void add_floor(std::vector<glm::vec3>& corners, float x0, float z0, float x1, float z1) {
  const glm::vec3 a(x0, 0, z0), b(x0, 0, z1), c(x1, 0, z1), d(x1, 0, z0);
  corners.insert(corners.end(), {a, b, c, a, c, d});
}

/// A uniform point of a triangle; now and then on an edge or a corner.
struct RandomPoint {
  float b1, b2;
};
inline RandomPoint random_point(std::mt19937& random) {
  std::uniform_real_distribution<float> unit(0.f, 1.f);
  float u = unit(random), v = unit(random);
  if (u + v > 1) u = 1 - u, v = 1 - v;
  switch (random() % 16) {
    case 0: u = 0; break;
    case 1: v = 0; break;
    case 2: v = 1 - u; break;
    case 3: u = float(random() % 2), v = u == 0 ? float(random() % 2) : 0; break;
    default: break;
  }
  return {u, v};
}

/// Texel areas sum to the surface's, texel sides are numbered as said, pieces cover every triangle once.
inline void check_sums(const AtlasGeometry& g, const AtlasLayout& layout) {
  const AtlasInfo& info = layout.info;
  REQUIRE(layout.texels.size() == info.texel_count);
  REQUIRE(layout.table.size() == info.cell_count);
  REQUIRE(2 * info.double_sided_count <= info.texel_count);
  for (const uint32_t texel : layout.table)
    REQUIRE((texel < info.double_sided_count || (texel >= 2 * info.double_sided_count && texel < info.texel_count)));
  double area = 0;
  for (const AtlasTexel& texel : layout.texels) area += double(texel.area);
  CHECK(area == test::relative(side_area(g), 1e-6));
  std::vector<double> covered(g.triangles.size(), 0);
  for (uint32_t side = 0; side < info.texel_count; ++side) {
    const bool two_sided = side < 2 * info.double_sided_count;
    const bool back = two_sided && side >= info.double_sided_count;
    double texel_area = 0;
    const uint2 range = layout.ranges[side];
    for (uint32_t i = range.x; i < range.x + range.y; ++i) {
      const TexelPiece& piece = layout.pieces[i];
      REQUIRE(bool(g.two_sided[g.instance[piece.triangle]]) == two_sided);
      if (!back) covered[piece.triangle] += double(piece.fraction);
      texel_area += double(piece.fraction) * area_of(g, piece.triangle);
    }
    CHECK(texel_area == test::relative(double(layout.texels[side].area), 1e-5));
  }
  for (uint32_t t = 0; t < covered.size(); ++t) {
    const glm::uvec3& v = g.triangles[t];
    const bool hit = !is_degenerate(g.positions[v.x], g.positions[v.y], g.positions[v.z]);
    CHECK_MESSAGE(std::abs(covered[t] - (hit ? 1 : 0)) < 1e-5, "triangle " << t);
  }
}

/// Every point finds a texel that has a piece of its triangle, or of one that touches it, within reach.
inline void check_lookups(
    const AtlasGeometry& g, const AtlasLayout& layout, uint32_t points,
    const std::function<bool(uint32_t)>& counts = [](uint32_t) { return true; }) {
  std::mt19937 random(7);
  const double reach = 4 * double(layout.info.texel_edge);
  uint32_t strangers = 0;
  for (uint32_t i = 0; i < points; ++i) {
    const uint32_t t = static_cast<uint32_t>(random() % g.triangles.size());
    const RandomPoint p = random_point(random);
    if (!counts(t)) continue;
    const uint32_t cell = atlas_cell(layout.triangles[t], p.b1, p.b2);
    REQUIRE(cell < layout.table.size());
    const uint32_t texel = layout.table[cell];
    REQUIRE_MESSAGE(texel != LUCARIUM_NONE, "triangle " << t << " at " << p.b1 << ", " << p.b2);
    const bool two_sided = g.two_sided[g.instance[t]];
    REQUIRE((two_sided ? texel < layout.info.double_sided_count
                       : texel >= 2 * layout.info.double_sided_count && texel < layout.info.texel_count));
    const AtlasTexel& sample = layout.texels[texel];
    REQUIRE(g.instance[sample.triangle] == g.instance[t]);
    const glm::dvec3 at = point_on(g, t, p.b1, p.b2), from = point_on(g, sample.triangle, sample.b1, sample.b2);
    CHECK_MESSAGE(glm::length(at - from) < reach, "triangle " << t << ", texel " << texel);
    const uint2 range = layout.ranges[texel];
    const bool own = std::any_of(layout.pieces.begin() + range.x, layout.pieces.begin() + range.x + range.y,
                                 [&](const TexelPiece& piece) { return piece.triangle == t; });
    strangers += !own;
  }
  CHECK(strangers < points / 10);
}

inline void check_layout(const AtlasGeometry& g, const AtlasLayout& layout, uint32_t points = 20000) {
  check_sums(g, layout);
  check_lookups(g, layout, points);
}

}  // namespace lucarium::test
