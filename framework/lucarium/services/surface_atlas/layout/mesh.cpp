// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/surface_atlas/layout/mesh.h"

#include <algorithm>
#include <tuple>

#include "lucarium/scene/device/degenerate_triangle.h"

namespace lucarium {
namespace {

constexpr double sliver_height = 1e-6;  // over the longest edge: positions are floats, so no normal is left below
constexpr double crease_degrees = 15;

}  // namespace

AtlasMesh::AtlasMesh(const AtlasGeometry& geometry_) : geometry(geometry_) {
  measure();
  weld();
  pair_edges();
}

void AtlasMesh::measure() {
  const size_t count = geometry.triangles.size();
  area.resize(count);
  normal.resize(count);
  for (uint32_t t = 0; t < count; ++t) {
    const glm::dvec3 a = position(t, 0), e1 = position(t, 1) - a, e2 = position(t, 2) - a, e3 = e2 - e1;
    const glm::dvec3 n = glm::cross(e1, e2);
    const double length = glm::length(n);
    const double longest = std::max({glm::dot(e1, e1), glm::dot(e2, e2), glm::dot(e3, e3)});
    area[t] = std::isfinite(length) ? 0.5 * length : 0;  // what is not finite cannot be hit
    normal[t] = std::isfinite(length) && length > sliver_height * longest ? glm::vec3(n / length) : glm::vec3(0);
  }
  leave_out();
}

void AtlasMesh::leave_out() {
  const uint32_t count = static_cast<uint32_t>(geometry.triangles.size());
  left_out.assign(count, 0);
  uint32_t hit = 0;
  for (uint32_t t = 0; t < count; ++t) {
    const glm::uvec3& corners = geometry.triangles[t];
    const auto& p = geometry.positions;
    left_out[t] = is_degenerate(p[corners.x], p[corners.y], p[corners.z]) || !(area[t] > 0);  // or not finite
    hit += !left_out[t];
    if (left_out[t]) area[t] = 0;  // not what rounding gives it
  }
  if (hit == 0 && count > 0) left_out[0] = 0;
  uint32_t next = 0;
  for (const uint8_t out : left_out) number.push_back(out ? next : next++);
}

void AtlasMesh::weld() {
  const size_t count = geometry.triangles.size();
  welded.resize(count);
  std::vector<glm::vec3> corners;
  for (size_t first = 0, last = 0; first < count; first = last) {
    corners.clear();
    for (; last < count && geometry.instance[last] == geometry.instance[first]; ++last)
      for (int i = 0; i < 3; ++i) corners.push_back(geometry.positions[geometry.triangles[last][i]]);
    const std::vector<uint32_t> equal = weld_positions(corners);
    for (size_t c = 0; c < equal.size(); ++c)
      welded[first + c / 3][int(c % 3)] = geometry.triangles[first + equal[c] / 3][int(equal[c] % 3)];
  }
}

void AtlasMesh::pair_edges() {
  neighbor.assign(triangle_count(), {LUCARIUM_NONE, LUCARIUM_NONE, LUCARIUM_NONE});
  hard.assign(triangle_count(), 0);
  std::vector<HalfEdge> edges = sorted_half_edges(welded);
  std::erase_if(edges, [this](const HalfEdge& edge) { return left_out[edge.triangle] != 0; });
  visit_edges(edges, [this](const HalfEdge* first, const HalfEdge* last) {
    if (last - first > 1) pair_group(first, last);
  });
}

// Half-edges between the same two vertices: oppositely oriented ones are joined, flattest first.
void AtlasMesh::pair_group(const HalfEdge* first, const HalfEdge* last) {
  std::vector<std::tuple<float, uint32_t, uint32_t>> pairs;
  for (const HalfEdge* a = first; a != last; ++a) {
    for (const HalfEdge* b = a + 1; b != last; ++b) {
      if (!run_opposite(welded, *a, *b) || a->triangle == b->triangle) continue;
      const uint32_t id_of_a = 3 * a->triangle + a->edge, id_of_b = 3 * b->triangle + b->edge;
      if (last - first == 2) return join(id_of_a, id_of_b);
      pairs.emplace_back(-glm::dot(normal[a->triangle], normal[b->triangle]), id_of_a, id_of_b);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  for (const auto& [flatness, a, b] : pairs) {
    if (neighbor[a / 3][a % 3] == LUCARIUM_NONE && neighbor[b / 3][b % 3] == LUCARIUM_NONE) join(a, b);
  }
}

void AtlasMesh::join(uint32_t a, uint32_t b) {
  static const float crease = static_cast<float>(cos_degrees(crease_degrees));
  const uint32_t ta = a / 3, tb = b / 3, ia = a % 3, ib = b % 3;
  neighbor[ta][ia] = tb;
  neighbor[tb][ib] = ta;
  if (normal[ta] == glm::vec3(0) || normal[tb] == glm::vec3(0) || glm::dot(normal[ta], normal[tb]) >= crease) return;
  const auto corner_normal = [&](uint32_t t, uint32_t i) { return geometry.normals[geometry.triangles[t][i % 3]]; };
  const bool smooth = glm::dot(corner_normal(ta, ia), corner_normal(tb, ib + 1)) >= crease &&
                      glm::dot(corner_normal(ta, ia + 1), corner_normal(tb, ib)) >= crease;
  if (smooth) return;
  hard[ta] |= 1u << ia;
  hard[tb] |= 1u << ib;
}

uint32_t number_parts(const AtlasMesh& mesh, const std::vector<uint32_t>& triangles,
                      const std::function<uint32_t(uint32_t)>& place, std::vector<uint32_t>& part) {
  part.assign(triangles.size(), LUCARIUM_NONE);
  uint32_t parts = 0;
  std::vector<uint32_t> open;
  for (uint32_t i = 0; i < triangles.size(); ++i) {
    if (part[i] != LUCARIUM_NONE) continue;
    part[i] = parts;
    open.push_back(i);
    while (!open.empty()) {
      const uint32_t current = open.back();
      open.pop_back();
      for (const uint32_t other : mesh.neighbor[triangles[current]]) {
        const uint32_t j = other == LUCARIUM_NONE ? LUCARIUM_NONE : place(other);
        if (j == LUCARIUM_NONE || part[j] != LUCARIUM_NONE) continue;
        part[j] = parts;
        open.push_back(j);
      }
    }
    ++parts;
  }
  return parts;
}

}  // namespace lucarium
