// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/mesh_components.h"

#include <algorithm>
#include <numeric>

#include "lucarium/scene/mesh_topology.h"

namespace lucarium {
namespace {

/// Sets of triangles that grow together; each is named by its first triangle.
class DisjointSets {
 public:
  explicit DisjointSets(size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }
  uint32_t find(uint32_t i) {
    for (; parent_[i] != i; i = parent_[i]) parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(uint32_t a, uint32_t b) {
    a = find(a), b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<uint32_t> parent_;
};

/// Of the tetrahedron of a triangle and `origin`, which should lie near, against cancellation.
double six_volumes(std::span<const glm::vec3> positions, const glm::uvec3& t, const glm::vec3& origin) {
  const glm::dvec3 o(origin), a = glm::dvec3(positions[t.x]) - o, b = glm::dvec3(positions[t.y]) - o,
                              c = glm::dvec3(positions[t.z]) - o;
  return glm::dot(a, glm::cross(b, c));
}

/// Whether the half-edges of one edge run through it as often in one direction as in the other.
bool balanced(std::span<const glm::uvec3> welded, const HalfEdge* first, const HalfEdge* last) {
  int64_t upward = 0;
  for (const HalfEdge* e = first; e != last; ++e)
    upward += welded[e->triangle][static_cast<int>(e->edge)] == e->low ? 1 : -1;
  return upward == 0;
}

}  // namespace

MeshComponents mesh_components(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles) {
  const std::vector<uint32_t> weld = weld_positions(positions);
  std::vector<glm::uvec3> welded;
  welded.reserve(triangles.size());
  for (const glm::uvec3& t : triangles) welded.emplace_back(weld[t.x], weld[t.y], weld[t.z]);
  const std::vector<HalfEdge> edges = sorted_half_edges(welded);
  DisjointSets sets(triangles.size());
  visit_edges(edges, [&](const HalfEdge* first, const HalfEdge* last) {
    for (const HalfEdge* e = first + 1; e < last; ++e) sets.join(first->triangle, e->triangle);
  });
  MeshComponents result;
  result.component_of.reserve(triangles.size());
  for (uint32_t t = 0; t < triangles.size(); ++t) {
    const uint32_t first = sets.find(t);
    const bool is_new = first == t;
    result.component_of.push_back(is_new ? static_cast<uint32_t>(result.components.size())
                                         : result.component_of[first]);
    if (is_new) result.components.emplace_back();
    MeshComponent& component = result.components[result.component_of[t]];
    ++component.triangles;
    component.volume += six_volumes(positions, triangles[t], positions[triangles[first].x]) / 6;
  }
  visit_edges(edges, [&](const HalfEdge* first, const HalfEdge* last) {
    if (!balanced(welded, first, last)) result.components[result.component_of[first->triangle]].closed = false;
  });
  return result;
}

double signed_volume(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles) {
  double sum = 0;
  for (const glm::uvec3& t : triangles) sum += six_volumes(positions, t, positions[triangles.front().x]);
  return sum / 6;
}

}  // namespace lucarium
