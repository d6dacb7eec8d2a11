// SPDX-License-Identifier: Apache-2.0
#include "virtual_light_field/tiles/patch_growth.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "lucarium/base/numbers.h"
#include "lucarium/scene/device/degenerate_triangle.h"
#include "lucarium/scene/mesh_topology.h"

namespace lucarium::vlf {
namespace {

constexpr double kFlat = 1e-4;  // of 1 - cos: within it normals are equal

/// Triangles across each triangle's edges, in one list.
struct Neighbors {
  std::vector<uint32_t> first, other;

  Neighbors(const PatchMesh& mesh, const std::vector<uint8_t>& taken) {
    const std::vector<uint32_t> welded = weld_positions(mesh.positions);
    std::vector<glm::uvec3> corners;
    std::vector<uint32_t> names;
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t)
      if (taken[t] && mesh.areas[t] > 0) {
        corners.emplace_back(welded[mesh.triangles[t].v0], welded[mesh.triangles[t].v1], welded[mesh.triangles[t].v2]);
        names.push_back(t);
      }
    std::vector<std::pair<uint32_t, uint32_t>> pairs;
    const std::vector<HalfEdge> edges = sorted_half_edges(corners);
    visit_edges(edges, [&](const HalfEdge* begin, const HalfEdge* end) {
      for (const HalfEdge* a = begin; a != end; ++a)
        for (const HalfEdge* b = begin; b != end; ++b)
          if (a->triangle != b->triangle && run_opposite(corners, *a, *b))
            pairs.emplace_back(names[a->triangle], names[b->triangle]);
    });
    std::sort(pairs.begin(), pairs.end());
    first.assign(mesh.triangles.size() + 1, 0);
    for (const auto& [a, b] : pairs) {
      ++first[a + 1];
      other.push_back(b);
    }
    std::partial_sum(first.begin(), first.end(), first.begin());
  }
};

}  // namespace

PatchMesh::PatchMesh(const SceneBuffers& buffers) : triangles(buffers.scene_triangles.download()) {
  for (const Vertex& v : buffers.scene_vertices.download()) positions.push_back(v.position.xyz());
  measure();
}

PatchMesh::PatchMesh(const Scene& scene, const std::vector<uint8_t>& taken) {
  for (uint32_t i = 0; i < scene.instances.size(); ++i) {
    if (!taken[i]) continue;
    const Mesh& mesh = scene.instances[i].shape(scene);
    const auto first = static_cast<uint32_t>(positions.size());
    for (const glm::vec3& p : mesh.positions)
      positions.emplace_back(scene.instances[i].world_from_object * glm::vec4(p, 1));
    for (const glm::uvec3& t : mesh.triangles) {
      Triangle triangle{};
      triangle.v0 = first + t.x;
      triangle.v1 = first + t.y;
      triangle.v2 = first + t.z;
      triangle.instance = i;
      triangles.push_back(triangle);
    }
  }
  measure();
}

void PatchMesh::measure() {
  for (const Triangle& t : triangles) {
    const glm::vec3 &a = positions[t.v0], &b = positions[t.v1], &c = positions[t.v2];
    const glm::vec3 cross = glm::cross(b - a, c - a);
    const float length = glm::length(cross);
    const bool flat = is_degenerate(a, b, c) || !(length > 0);
    normals.push_back(flat ? glm::vec3(0) : cross / length);
    areas.push_back(flat ? 0. : 0.5 * static_cast<double>(length));
  }
}

std::vector<uint32_t> grow_patches(const PatchMesh& mesh, const std::vector<uint8_t>& taken, double cone,
                                   uint32_t* count) {
  const Neighbors neighbors(mesh, taken);
  const double least = std::cos(cone * pi / 180) - kFlat;
  std::vector<uint32_t> order, result(mesh.triangles.size(), LUCARIUM_NONE), open;
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t)
    if (taken[t]) order.push_back(t);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return mesh.areas[a] > mesh.areas[b]; });
  *count = 0;
  for (const uint32_t seed : order) {
    if (result[seed] != LUCARIUM_NONE) continue;
    const uint32_t patch = (*count)++;
    result[seed] = patch;
    open.assign(1, seed);
    for (size_t i = 0; i < open.size(); ++i)
      for (uint32_t k = neighbors.first[open[i]]; k < neighbors.first[open[i] + 1]; ++k) {
        const uint32_t t = neighbors.other[k];
        if (result[t] != LUCARIUM_NONE || mesh.triangles[t].instance != mesh.triangles[seed].instance ||
            static_cast<double>(glm::dot(mesh.normals[t], mesh.normals[seed])) < least)
          continue;
        result[t] = patch;
        open.push_back(t);
      }
  }
  return result;
}

std::vector<uint32_t> connected_surfaces(const PatchMesh& mesh, double angle) {
  const auto count = static_cast<uint32_t>(mesh.triangles.size());
  const Neighbors neighbors(mesh, std::vector<uint8_t>(count, 1));
  const double least = std::cos(angle * pi / 180);
  std::vector<uint32_t> result(count, LUCARIUM_NONE), open;
  for (uint32_t seed = 0; seed < count; ++seed) {
    if (result[seed] != LUCARIUM_NONE) continue;
    result[seed] = seed;
    open.assign(1, seed);
    while (!open.empty()) {
      const uint32_t t = open.back();
      open.pop_back();
      for (uint32_t k = neighbors.first[t]; k < neighbors.first[t + 1]; ++k) {
        const uint32_t other = neighbors.other[k];
        if (result[other] != LUCARIUM_NONE ||
            static_cast<double>(glm::dot(mesh.normals[t], mesh.normals[other])) < least)
          continue;
        result[other] = seed;
        open.push_back(other);
      }
    }
  }
  return result;
}

}  // namespace lucarium::vlf
