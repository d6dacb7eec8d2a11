// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/texel_sides/texel_extent.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "lucarium/scene/device/degenerate_triangle.h"

namespace lucarium {
namespace {

constexpr size_t kMaxCorners = 1024;
constexpr double kLookUp = 1.001;  // cells end where a look-up may round to, 1e-4 of them beyond their edges

double box_diagonal(const Bounds& box) {
  return box.empty() ? 0.0 : static_cast<double>(glm::length(box.max - box.min));
}

/// A convex polygon of few corners: where they lie in the cells, and in space.
struct Polygon {
  struct Corner {
    glm::dvec2 uv;
    glm::dvec3 position;
  };
  Corner corners[8];
  int count = 0;
};

/// The part of a polygon where sign (uv[axis] - edge) >= 0 (Sutherland and Hodgman).
Polygon cut(const Polygon& polygon, int axis, double sign, double edge) {
  Polygon result;
  for (int i = 0; i < polygon.count; ++i) {
    const Polygon::Corner &a = polygon.corners[i], &b = polygon.corners[(i + 1) % polygon.count];
    const double da = sign * (a.uv[axis] - edge), db = sign * (b.uv[axis] - edge), at = da / (da - db);
    if (da >= 0) result.corners[result.count++] = a;
    if ((da < 0) != (db < 0))
      result.corners[result.count++] = {a.uv + at * (b.uv - a.uv), a.position + at * (b.position - a.position)};
  }
  return result;
}

/// Calls visit(texel, point) for the corners of every piece of a triangle.
template <class Visit>
void visit_corners(const AtlasTriangle& t, const glm::vec3 (&p)[3], const std::vector<uint32_t>& table,
                   const Visit& visit) {
  const glm::dvec2 uv[3] = {{t.u0, t.v0}, {t.u1, t.v1}, {t.u2, t.v2}};
  const auto texel = [&](int u, int v) {
    return table[t.base + static_cast<uint32_t>(v) * LUCARIUM_ATLAS_PITCH(t) + static_cast<uint32_t>(u)];
  };
  const glm::dvec2 low = glm::min(uv[0], glm::min(uv[1], uv[2])), high = glm::max(uv[0], glm::max(uv[1], uv[2]));
  const glm::ivec2 first(low), last(high);
  for (int v = first.y; v <= last.y; ++v)
    for (int u = first.x; u <= last.x; ++u) {
      if (first == last) {
        for (const glm::vec3& corner : p) visit(texel(u, v), corner);
        continue;
      }
      // Space goes along with the cuts: of a sliver's uv alone it could not be found again.
      Polygon polygon{{{uv[0], p[0]}, {uv[1], p[1]}, {uv[2], p[2]}}, 3};
      polygon = cut(cut(cut(cut(polygon, 0, 1, u), 0, -1, u + 1), 1, 1, v), 1, -1, v + 1);
      for (int i = 0; i < polygon.count; ++i) visit(texel(u, v), glm::vec3(polygon.corners[i].position));
    }
}

double largest_distance(const std::vector<glm::vec3>& points) {
  float square = 0;
  for (size_t i = 0; i < points.size(); ++i)
    for (size_t j = 0; j < i; ++j) {
      const glm::vec3 d = points[i] - points[j];
      square = std::max(square, glm::dot(d, d));
    }
  return std::sqrt(static_cast<double>(square));
}

}  // namespace

double largest_texel_extent(const SurfaceAtlas& atlas, const SceneBuffers& buffers, double limit) {
  const std::vector<AtlasTriangle> records = atlas.triangles().download();
  const std::vector<uint32_t> table = atlas.table().download();
  const auto triangles = buffers.scene_triangles.download();
  const auto vertices = buffers.scene_vertices.download();
  const auto visit_all = [&](const auto& visit) {
    for (size_t k = 0; k < records.size(); ++k) {
      const auto position = [&](uint32_t v) {
        return glm::vec3(vertices[v].position.x, vertices[v].position.y, vertices[v].position.z);
      };
      const glm::vec3 p[3] = {position(triangles[k].v0), position(triangles[k].v1), position(triangles[k].v2)};
      if (is_degenerate(p[0], p[1], p[2])) continue;  // no ray ends there, however long it is
      visit_corners(records[k], p, table, visit);
    }
  };
  std::vector<Bounds> boxes(atlas.info().texel_count);
  visit_all([&](uint32_t texel, const glm::vec3& p) { boxes[texel].add(p); });
  double result = 0;
  std::unordered_map<uint32_t, std::vector<glm::vec3>> large;  // texels whose box is longer than the limit
  for (uint32_t texel = 0; texel < boxes.size(); ++texel) {
    const double diagonal = kLookUp * box_diagonal(boxes[texel]);
    if (diagonal > limit)
      large[texel];
    else
      result = std::max(result, diagonal);
  }
  if (large.empty()) return result;
  visit_all([&](uint32_t texel, const glm::vec3& p) {
    const auto found = large.find(texel);
    if (found != large.end() && found->second.size() <= kMaxCorners) found->second.push_back(p);
  });
  for (const auto& [texel, points] : large)
    result = std::max(result, points.size() > kMaxCorners ? kLookUp * box_diagonal(boxes[texel])
                                                          : kLookUp * largest_distance(points));
  return result;
}

}  // namespace lucarium
