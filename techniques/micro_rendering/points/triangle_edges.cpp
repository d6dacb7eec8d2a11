// SPDX-License-Identifier: Apache-2.0
#include "micro_rendering/points/triangle_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "lucarium/scene/mesh_topology.h"

namespace lucarium::micro {
namespace {

constexpr float kCrease = 0.35f;  // angle from which on an edge counts [rad]
constexpr float kBorder = 1e9f;
constexpr size_t kMaxFaces =
    64;  // of one edge that are compared: copies of a triangle must not cost their number's square
constexpr uint32_t kSheets = 127;  // maximum number of different sheets

struct Face {
  std::array<glm::vec3, 3> corners;
  uint32_t triangle;
  bool two_sided;
  std::array<float, 3> bend{kBorder, kBorder,
                            kBorder};  ///< at the edge from corner k to the next one [rad]; least over neighbours
  std::array<uint32_t, 3> beside{};    ///< face behind that edge
};

std::vector<Face> faces_of(const TreeSource& source) {
  std::vector<Face> faces;
  for (const SurfaceSide& side : source.sides) {
    if (side.back) {
      faces.back().two_sided = true;  // follows its front
    } else {
      faces.push_back({{side.v0, side.v1, side.v2}, side.source, false});
    }
  }
  return faces;
}

/// The corners of faces, equal positions as one.
std::vector<glm::uvec3> weld(const std::vector<Face>& faces) {
  std::vector<glm::vec3> positions;
  for (const Face& face : faces) positions.insert(positions.end(), face.corners.begin(), face.corners.end());
  const std::vector<uint32_t> first = weld_positions(positions);
  std::vector<glm::uvec3> welded;
  for (size_t i = 0; i < first.size(); i += 3) welded.emplace_back(first[i], first[i + 1], first[i + 2]);
  return welded;
}

/// Angle by which face b behind edge k of face a bends away from a's front; to either side where a has two. None:
/// kBorder.
float bend_of(const Face& a, uint32_t k, const Face& b, uint32_t k_of_b) {
  const glm::vec3 normal = glm::cross(a.corners[1] - a.corners[0], a.corners[2] - a.corners[0]);
  const float angle = dihedral_bend(a.corners[k], a.corners[(k + 1) % 3], normal, b.corners[(k_of_b + 2) % 3]);
  if (std::isnan(angle)) return kBorder;
  return a.two_sided ? std::abs(angle) : std::max(angle, 0.f);
}

uint32_t root_of(std::vector<uint32_t>& parents, uint32_t i) {
  while (parents[i] != i) i = parents[i] = parents[parents[i]];
  return i;
}

/// Bends at all edges. Returns for each face the number of its sheet: faces that are wound alike across common edges.
std::vector<uint32_t> join(std::vector<Face>& faces) {
  std::vector<uint32_t> parents(faces.size());
  std::iota(parents.begin(), parents.end(), 0u);
  const std::vector<glm::uvec3> welded = weld(faces);
  visit_edges(sorted_half_edges(welded), [&](const HalfEdge* first, const HalfEdge* end) {
    const HalfEdge* const compared = first + std::min<size_t>(static_cast<size_t>(end - first), kMaxFaces);
    for (const HalfEdge* a = first; a != end; ++a) {
      for (const HalfEdge* b = first; b != compared; ++b) {
        if (a->triangle == b->triangle) continue;
        Face &face = faces[a->triangle], &other = faces[b->triangle];
        const float bend = bend_of(face, a->edge, other, b->edge);
        if (bend < face.bend[a->edge]) face.bend[a->edge] = bend, face.beside[a->edge] = b->triangle;
        if (run_opposite(welded, *a, *b) && face.two_sided && other.two_sided)
          parents[root_of(parents, a->triangle)] = root_of(parents, b->triangle);
      }
    }
  });
  for (uint32_t f = 0; f < faces.size(); ++f) parents[f] = root_of(parents, f);
  return parents;
}

/// Puts the edges of `face` at which its surface ends into free places.
void add_edges(const Face& face, const Triangle& triangle, TriangleEdges& edges, int& count) {
  const uint32_t vertices[3] = {triangle.v0, triangle.v1, triangle.v2};
  for (size_t k = 0; k < 3 && count < MICRO_CLIPS; ++k) {
    if (face.bend[k] <= kCrease) continue;
    edges.ends[2 * count] = vertices[k];
    edges.ends[2 * count + 1] = vertices[(k + 1) % 3];
    ++count;
  }
}

}  // namespace

std::vector<TriangleEdges> find_triangle_edges(const std::vector<TreeSource>& sources,
                                               const std::vector<Triangle>& triangles) {
  TriangleEdges nothing;
  std::fill(std::begin(nothing.ends), std::end(nothing.ends), LUCARIUM_NONE);
  nothing.own = nothing.sheet = 0;
  std::vector<TriangleEdges> triangle_edges(triangles.size(), nothing);
  for (const TreeSource& source : sources) {
    std::vector<Face> faces = faces_of(source);
    const std::vector<uint32_t> sheets = join(faces);
    for (uint32_t f = 0; f < faces.size(); ++f) {
      const Face& face = faces[f];
      TriangleEdges& edges = triangle_edges[face.triangle];
      int count = 0;
      add_edges(face, triangles[face.triangle], edges, count);
      edges.own = static_cast<uint>(count);
      for (size_t k = 0; k < 3; ++k)
        if (face.bend[k] <= kCrease)
          add_edges(faces[face.beside[k]], triangles[faces[face.beside[k]].triangle], edges, count);
      if (face.two_sided) edges.sheet = 1 + sheets[f] % kSheets;
    }
  }
  return triangle_edges;
}

}  // namespace lucarium::micro
