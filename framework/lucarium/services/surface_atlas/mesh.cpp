// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/surface_atlas/mesh.h"

#include <algorithm>
#include <bit>
#include <tuple>

namespace lucarium {

struct AtlasHalfEdge {
  uint64_t vertices;  ///< the two welded vertices, the lower one in the upper half
  uint32_t id;        ///< 3 · triangle + edge
};

namespace {

constexpr double sliver_height = 1e-6;  // over the longest edge: positions are floats, so no normal is left below
constexpr double crease_degrees = 15;

uint64_t position_key(const glm::vec3& p, int axis) { return std::bit_cast<uint32_t>(p[axis] + 0.f); }  // -0 → 0

uint64_t hash_position(const glm::vec3& p) {
  uint64_t h = position_key(p, 0) * 0x9e3779b97f4a7c15ull;
  h = (h ^ (h >> 29) ^ position_key(p, 1)) * 0xbf58476d1ce4e5b9ull;
  h = (h ^ (h >> 32) ^ position_key(p, 2)) * 0x94d049bb133111ebull;
  return h ^ (h >> 31);
}

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
}

void AtlasMesh::weld() {
  const size_t count = geometry.triangles.size();
  welded.resize(count);
  std::vector<uint32_t> slots;
  for (size_t first = 0, last = 0; first < count; first = last) {
    while (last < count && geometry.instance[last] == geometry.instance[first]) ++last;
    slots.assign(std::bit_ceil(std::max<size_t>(8, 6 * (last - first))), LUCARIUM_NONE);
    for (size_t t = first; t < last; ++t) {
      for (int i = 0; i < 3; ++i) {
        const uint32_t vertex = geometry.triangles[t][i];
        const glm::vec3& p = geometry.positions[vertex];
        size_t at = hash_position(p) & (slots.size() - 1);
        while (slots[at] != LUCARIUM_NONE && geometry.positions[slots[at]] != p) at = (at + 1) & (slots.size() - 1);
        if (slots[at] == LUCARIUM_NONE) slots[at] = vertex;
        welded[t][i] = slots[at];
      }
    }
  }
}

void AtlasMesh::pair_edges() {
  const size_t count = triangle_count();
  neighbor.assign(count, {LUCARIUM_NONE, LUCARIUM_NONE, LUCARIUM_NONE});
  hard.assign(count, 0);
  std::vector<AtlasHalfEdge> edges;
  edges.reserve(3 * count);
  for (uint32_t t = 0; t < count; ++t) {
    for (uint32_t i = 0; i < 3; ++i) {
      const uint64_t a = welded[t][i], b = welded[t][(i + 1) % 3];
      if (a != b) edges.push_back({std::min(a, b) << 32 | std::max(a, b), 3 * t + i});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const AtlasHalfEdge& a, const AtlasHalfEdge& b) {
    return std::tie(a.vertices, a.id) < std::tie(b.vertices, b.id);
  });
  for (size_t first = 0, last = 0; first < edges.size(); first = last) {
    while (last < edges.size() && edges[last].vertices == edges[first].vertices) ++last;
    if (last - first > 1) pair_group(&edges[first], &edges[first] + (last - first));
  }
}

// Half-edges between the same two vertices: oppositely oriented ones are joined, flattest first.
void AtlasMesh::pair_group(const AtlasHalfEdge* first, const AtlasHalfEdge* last) {
  const auto starts_low = [&](uint32_t id) { return welded[id / 3][id % 3] == uint32_t(first->vertices >> 32); };
  std::vector<std::tuple<float, uint32_t, uint32_t>> pairs;
  for (const AtlasHalfEdge* a = first; a != last; ++a) {
    for (const AtlasHalfEdge* b = a + 1; b != last; ++b) {
      if (starts_low(a->id) == starts_low(b->id) || a->id / 3 == b->id / 3) continue;
      if (last - first == 2) return join(a->id, b->id);
      pairs.emplace_back(-glm::dot(normal[a->id / 3], normal[b->id / 3]), a->id, b->id);
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
