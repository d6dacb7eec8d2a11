// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/mesh_topology.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <tuple>

#include "lucarium/scene/mesh_components.h"

namespace lucarium {
namespace {

constexpr uint32_t empty = ~0u;

uint64_t position_key(const glm::vec3& p, int axis) { return std::bit_cast<uint32_t>(p[axis] + 0.f); }  // -0 → 0

uint64_t hash_position(const glm::vec3& p) {
  uint64_t h = position_key(p, 0) * 0x9e3779b97f4a7c15ull;
  h = (h ^ (h >> 29) ^ position_key(p, 1)) * 0xbf58476d1ce4e5b9ull;
  h = (h ^ (h >> 32) ^ position_key(p, 2)) * 0x94d049bb133111ebull;
  return h ^ (h >> 31);
}

}  // namespace

std::vector<uint32_t> weld_positions(std::span<const glm::vec3> positions) {
  std::vector<uint32_t> first(positions.size());
  std::vector<uint32_t> slots(std::bit_ceil(std::max<size_t>(8, 2 * positions.size())), empty);
  for (uint32_t i = 0; i < positions.size(); ++i) {
    size_t at = hash_position(positions[i]) & (slots.size() - 1);
    while (slots[at] != empty && positions[slots[at]] != positions[i]) at = (at + 1) & (slots.size() - 1);
    if (slots[at] == empty) slots[at] = i;
    first[i] = slots[at];
  }
  return first;
}

std::vector<HalfEdge> sorted_half_edges(std::span<const glm::uvec3> welded) {
  std::vector<HalfEdge> edges;
  edges.reserve(3 * welded.size());
  for (uint32_t t = 0; t < welded.size(); ++t) {
    for (uint32_t i = 0; i < 3; ++i) {
      const uint32_t a = welded[t][static_cast<int>(i)], b = welded[t][static_cast<int>((i + 1) % 3)];
      if (a != b) edges.push_back({std::min(a, b), std::max(a, b), t, i});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::tie(a.low, a.high, a.triangle, a.edge) < std::tie(b.low, b.high, b.triangle, b.edge);
  });
  return edges;
}

bool run_opposite(std::span<const glm::uvec3> welded, const HalfEdge& a, const HalfEdge& b) {
  return welded[a.triangle][static_cast<int>(a.edge)] != welded[b.triangle][static_cast<int>(b.edge)];
}

bool is_closed(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles) {
  const std::vector<MeshComponent> components = mesh_components(positions, triangles).components;
  return std::all_of(components.begin(), components.end(), [](const MeshComponent& c) { return c.closed; });
}

float dihedral_bend(const glm::vec3& a, const glm::vec3& b, const glm::vec3& normal, const glm::vec3& opposite) {
  const glm::vec3 edge = b - a;
  const float length = glm::length(edge), area = glm::length(normal);
  if (!(length > 0) || !(area > 0)) return std::numeric_limits<float>::quiet_NaN();
  glm::vec3 across = opposite - a;
  across -= edge * (glm::dot(across, edge) / (length * length));
  const float away = -glm::dot(across, normal) / area,
              on = glm::dot(across, glm::cross(edge, normal)) / (length * area);
  return away == 0 && on == 0 ? std::numeric_limits<float>::quiet_NaN() : std::atan2(away, on);
}

}  // namespace lucarium
