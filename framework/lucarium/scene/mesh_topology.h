// SPDX-License-Identifier: Apache-2.0
// Which triangles touch which.
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace lucarium {

/// For each position the index of the first equal one (-0 is 0). A NaN equals nothing.
std::vector<uint32_t> weld_positions(std::span<const glm::vec3> positions);

/// One side of an edge: that of corner `edge` of a triangle to the next corner.
struct HalfEdge {
  uint32_t low, high;  ///< its two vertices, low < high
  uint32_t triangle;
  uint32_t edge;  ///< 0 … 2
};

/// The half-edges of triangles whose corners are welded vertices: those between the same two vertices stand together,
/// in order of their triangles. Edges without length are left out.
std::vector<HalfEdge> sorted_half_edges(std::span<const glm::uvec3> welded);

/// Calls visit(first, last) for each run of half-edges between the same two vertices.
template <class Visit>
void visit_edges(const std::vector<HalfEdge>& half_edges, const Visit& visit) {
  for (size_t first = 0, last = 0; first < half_edges.size(); first = last) {
    while (last < half_edges.size() && half_edges[last].low == half_edges[first].low &&
           half_edges[last].high == half_edges[first].high)
      ++last;
    visit(half_edges.data() + first, half_edges.data() + last);
  }
}

/// Whether two half-edges of the same edge run in opposite directions, as those of neighbours do that are wound alike.
bool run_opposite(std::span<const glm::uvec3> welded, const HalfEdge& a, const HalfEdge& b);

/// Whether the triangles enclose volumes: every edge is run through as often in one direction as in the other.
bool is_closed(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles);

/// Angle by which a triangle bends away from the front of another across their common edge from a to b [rad]: 0 where
/// it goes on flat, up to π where it folds behind the front, below 0 where it rises before it. `normal` is the other's,
/// of any length, `opposite` the triangle's corner off the edge. NaN where one of the two has no area beside the edge.
float dihedral_bend(const glm::vec3& a, const glm::vec3& b, const glm::vec3& normal, const glm::vec3& opposite);

}  // namespace lucarium
