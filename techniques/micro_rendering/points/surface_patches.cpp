// SPDX-License-Identifier: Apache-2.0
#include "micro_rendering/points/surface_patches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>
#include <unordered_map>

namespace lucarium::micro {
namespace {

constexpr float kCrease = 0.35f;  // angle from which on an edge counts [rad]
constexpr float kBorder = 1e9f;
constexpr size_t kMostFaces =
    64;  // of one edge that are compared: copies of a triangle must not cost their number's square
constexpr uint32_t kSheets = 127;  // that are told apart

struct Face {
  std::array<glm::vec3, 3> corners;
  std::array<uint32_t, 3> points;  ///< corners of the same position have the same number
  uint32_t triangle;
  bool two_sided;
  std::array<float, 3> bend{kBorder, kBorder,
                            kBorder};  ///< at the edge from corner k to the next one [rad]; least over neighbours
  std::array<uint32_t, 3> beside{};    ///< face behind that edge
};

struct HalfEdge {
  uint32_t low, high;  ///< points
  uint32_t face, k;
};

struct PositionHash {
  size_t operator()(const glm::vec3& p) const {
    size_t h = 0;
    for (int i = 0; i < 3; ++i) h = (h ^ std::hash<float>()(p[i])) * 0x9e3779b97f4a7c15u;
    return h ^ h >> 29;
  }
};

std::vector<Face> faces_of(const TreeSource& source) {
  std::vector<Face> faces;
  std::unordered_map<glm::vec3, uint32_t, PositionHash> numbers;
  for (const SurfaceSide& side : source.sides) {
    if (side.back) {
      faces.back().two_sided = true;  // follows its front
      continue;
    }
    Face face{{side.v0, side.v1, side.v2}, {}, side.source, false};
    for (size_t k = 0; k < 3; ++k)
      face.points[k] = numbers.try_emplace(face.corners[k] + 0.f, static_cast<uint32_t>(numbers.size())).first->second;
    faces.push_back(face);
  }
  return faces;
}

/// The halves of all edges, those of one edge together.
std::vector<HalfEdge> half_edges(const std::vector<Face>& faces) {
  std::vector<HalfEdge> edges;
  for (uint32_t f = 0; f < faces.size(); ++f) {
    for (uint32_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(faces[f].points[k], faces[f].points[(k + 1) % 3]);
      if (low != high) edges.push_back({low, high, f, k});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::tie(a.low, a.high, a.face, a.k) < std::tie(b.low, b.high, b.face, b.k);
  });
  return edges;
}

/// Angle by which face b behind edge k of face a bends away from a's front; to either side where a has two. None:
/// kBorder.
float bend_of(const Face& a, uint32_t k, const Face& b, uint32_t k_of_b) {
  const glm::vec3 from = a.corners[k], edge = a.corners[(k + 1) % 3] - from;
  const glm::vec3 normal = glm::cross(a.corners[1] - a.corners[0], a.corners[2] - a.corners[0]);
  const float length = glm::length(edge), area = glm::length(normal);
  if (!(length > 0) || !(area > 0)) return kBorder;
  glm::vec3 across = b.corners[(k_of_b + 2) % 3] - from;
  across -= edge * (glm::dot(across, edge) / (length * length));
  const float away = -glm::dot(across, normal) / area,
              on = glm::dot(across, glm::cross(edge, normal)) / (length * area);
  if (away == 0 && on == 0) return kBorder;
  const float angle = std::atan2(away, on);
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
  const std::vector<HalfEdge> edges = half_edges(faces);
  for (size_t first = 0, end; first < edges.size(); first = end) {
    end = first + 1;
    while (end < edges.size() && edges[end].low == edges[first].low && edges[end].high == edges[first].high) ++end;
    for (size_t i = first; i < end; ++i) {
      for (size_t j = first; j < std::min(end, first + kMostFaces); ++j) {
        const HalfEdge &a = edges[i], &b = edges[j];
        if (a.face == b.face) continue;
        Face& face = faces[a.face];
        const float bend = bend_of(face, a.k, faces[b.face], b.k);
        if (bend < face.bend[a.k]) face.bend[a.k] = bend, face.beside[a.k] = b.face;
        const bool alike = face.points[a.k] != faces[b.face].points[b.k];  // the edge runs the other way there
        if (alike && face.two_sided && faces[b.face].two_sided)
          parents[root_of(parents, a.face)] = root_of(parents, b.face);
      }
    }
  }
  for (uint32_t f = 0; f < faces.size(); ++f) parents[f] = root_of(parents, f);
  return parents;
}

/// Puts the edges of `face` at which its surface ends into free places of a patch.
void add_edges(const Face& face, const Triangle& triangle, MicroPatch& patch, int& count) {
  const uint32_t vertices[3] = {triangle.v0, triangle.v1, triangle.v2};
  for (size_t k = 0; k < 3 && count < MICRO_CLIPS; ++k) {
    if (face.bend[k] <= kCrease) continue;
    patch.ends[2 * count] = vertices[k];
    patch.ends[2 * count + 1] = vertices[(k + 1) % 3];
    ++count;
  }
}

}  // namespace

std::vector<MicroPatch> find_patches(const std::vector<TreeSource>& sources, const std::vector<Triangle>& triangles) {
  MicroPatch nothing;
  std::fill(std::begin(nothing.ends), std::end(nothing.ends), LUCARIUM_NONE);
  nothing.own = nothing.sheet = 0;
  std::vector<MicroPatch> patches(triangles.size(), nothing);
  for (const TreeSource& source : sources) {
    std::vector<Face> faces = faces_of(source);
    const std::vector<uint32_t> sheets = join(faces);
    for (uint32_t f = 0; f < faces.size(); ++f) {
      const Face& face = faces[f];
      MicroPatch& patch = patches[face.triangle];
      int count = 0;
      add_edges(face, triangles[face.triangle], patch, count);
      patch.own = static_cast<uint>(count);
      for (size_t k = 0; k < 3; ++k)
        if (face.bend[k] <= kCrease)
          add_edges(faces[face.beside[k]], triangles[faces[face.beside[k]].triangle], patch, count);
      if (face.two_sided) patch.sheet = 1 + sheets[f] % kSheets;
    }
  }
  return patches;
}

}  // namespace lucarium::micro
