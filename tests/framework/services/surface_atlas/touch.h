// SPDX-License-Identifier: Apache-2.0
// The bleeding check of the surface atlas, by geometry alone: whatever looks up a texel hangs together in space.
#pragma once
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "support.h"

namespace lucarium::test {

/// Parts of triangles, by the texel that they look up.
struct TexelPolygon {
  uint32_t texel, triangle;
  uint32_t first, count;  ///< corners
};

struct TexelPolygons {
  std::vector<TexelPolygon> polygons;
  std::vector<glm::dvec3> corners;
};

inline std::vector<glm::dvec2> clip_half(const std::vector<glm::dvec2>& polygon, int axis, double value, double sign) {
  std::vector<glm::dvec2> result;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const glm::dvec2 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
    const double da = sign * (a[axis] - value), db = sign * (b[axis] - value);
    if (da >= 0) result.push_back(a);
    if ((da < 0) != (db < 0)) result.push_back(a + da / (da - db) * (b - a));
  }
  return result;
}

/// Every part of every triangle that may look up a cell, `margin` cells around it included.
inline TexelPolygons polygons_by_texel(const AtlasGeometry& g, const AtlasLayout& layout, double margin) {
  TexelPolygons result;
  const auto add = [&](uint32_t texel, uint32_t t, const std::vector<glm::dvec2>& barycentrics) {
    result.polygons.push_back({texel, t, uint32_t(result.corners.size()), uint32_t(barycentrics.size())});
    const glm::dvec3 a = corner(g, t, 0), e1 = corner(g, t, 1) - a, e2 = corner(g, t, 2) - a;
    for (const glm::dvec2& b : barycentrics) result.corners.push_back(a + b.x * e1 + b.y * e2);
  };
  for (uint32_t t = 0; t < g.triangles.size(); ++t) {
    const glm::uvec3& v = g.triangles[t];
    if (is_degenerate(g.positions[v.x], g.positions[v.y], g.positions[v.z])) continue;  // never looks anything up
    const AtlasTriangle& r = layout.triangles[t];
    const glm::dvec2 a(r.u0, r.v0), e1 = glm::dvec2(r.u1, r.v1) - a, e2 = glm::dvec2(r.u2, r.v2) - a;
    const std::vector<glm::dvec2> whole = {{0, 0}, {1, 0}, {0, 1}};
    const double twice = e1.x * e2.y - e1.y * e2.x;
    if (LUCARIUM_ATLAS_PITCH(r) == 0) {
      add(layout.table[r.base], t, whole);
      continue;
    }
    if (std::abs(twice) < 1e-10) continue;
    const auto barycentrics = [&](const glm::dvec2& p) {
      const glm::dvec2 d = p - a;
      return glm::dvec2(d.x * e2.y - d.y * e2.x, e1.x * d.y - e1.y * d.x) / twice;
    };
    const glm::dvec2 high = glm::max(a, glm::max(a + e1, a + e2));
    for (int y = 0; y <= int(high.y); ++y) {
      std::vector<glm::dvec2> row = {a, a + e1, a + e2};
      row = clip_half(clip_half(row, 1, y - margin, 1), 1, y + 1 + margin, -1);
      for (int x = 0; x <= int(high.x); ++x) {
        std::vector<glm::dvec2> cell = clip_half(clip_half(row, 0, x - margin, 1), 0, x + 1 + margin, -1);
        if (cell.empty()) continue;
        for (glm::dvec2& p : cell) p = barycentrics(p);
        const uint32_t texel = layout.table[r.base + uint32_t(y) * LUCARIUM_ATLAS_PITCH(r) + uint32_t(x)];
        if (texel != LUCARIUM_NONE) add(texel, t, cell);
      }
    }
  }
  return result;
}

/// Distance of two segments (Ericson, Real-Time Collision Detection, section 5.1.9).
inline double segment_distance(const glm::dvec3& p1, const glm::dvec3& q1, const glm::dvec3& p2, const glm::dvec3& q2) {
  const glm::dvec3 d1 = q1 - p1, d2 = q2 - p2, r = p1 - p2;
  const double a = glm::dot(d1, d1), e = glm::dot(d2, d2), f = glm::dot(d2, r), c = glm::dot(d1, r);
  const double b = glm::dot(d1, d2), det = a * e - b * b;
  double s = det > 1e-12 * a * e ? std::clamp((b * f - c * e) / det, 0., 1.) : 0;
  double t = e > 0 ? std::clamp((b * s + f) / e, 0., 1.) : 0;
  s = a > 0 ? std::clamp((b * t - c) / a, 0., 1.) : 0;
  t = e > 0 ? std::clamp((b * s + f) / e, 0., 1.) : 0;
  return glm::length(p1 + s * d1 - p2 - t * d2);
}

inline bool polygons_touch(const TexelPolygons& all, const TexelPolygon& a, const TexelPolygon& b, double tolerance) {
  const auto at = [&](const TexelPolygon& p, uint32_t i) { return all.corners[p.first + i % p.count]; };
  for (uint32_t i = 0; i < a.count; ++i)
    for (uint32_t j = 0; j < b.count; ++j)
      if (segment_distance(at(a, i), at(a, i + 1), at(b, j), at(b, j + 1)) <= tolerance) return true;
  return false;
}

/// Texels whose parts do not hang together; `tolerance` in texel edges.
inline std::vector<uint32_t> bad_texels(const AtlasGeometry& g, const AtlasLayout& layout, double margin = 1e-4,
                                        double tolerance = 1e-3) {
  TexelPolygons all = polygons_by_texel(g, layout, margin);
  std::stable_sort(all.polygons.begin(), all.polygons.end(),
                   [](const TexelPolygon& a, const TexelPolygon& b) { return a.texel < b.texel; });
  std::vector<uint32_t> bad, open;
  for (size_t first = 0, last = 0; first < all.polygons.size(); first = last) {
    while (last < all.polygons.size() && all.polygons[last].texel == all.polygons[first].texel) ++last;
    std::vector<uint8_t> reached(last - first, 0);
    size_t count = 1;
    reached[0] = 1;
    open.assign(1, uint32_t(first));
    while (!open.empty()) {
      const TexelPolygon current = all.polygons[open.back()];
      open.pop_back();
      for (size_t i = first; i < last; ++i) {
        if (reached[i - first]) continue;
        if (!polygons_touch(all, current, all.polygons[i], tolerance * double(layout.info.texel_edge))) continue;
        reached[i - first] = 1;
        ++count;
        open.push_back(uint32_t(i));
      }
    }
    if (count != last - first) bad.push_back(all.polygons[first].texel);
  }
  return bad;
}

}  // namespace lucarium::test
