// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <utility>

#include "lucarium/scene/scene.h"

namespace lucarium::test {

inline float largest_difference(const glm::vec3& a, const glm::vec3& b) {
  const glm::vec3 d = glm::abs(a - b);
  return std::max(std::max(d.x, d.y), d.z);
}

/// A single triangle (0,0,0) (1,0,0) (0,1,0), facing +Z.
inline Mesh triangle_mesh() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.normals.assign(3, glm::vec3(0, 0, 1));
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

/// One node with one instance of one mesh and a white material.
inline Scene one_node_scene(Mesh mesh) {
  Scene scene;
  scene.source = "test";
  scene.meshes.push_back(std::move(mesh));
  scene.materials.emplace_back();
  Node node;
  node.meshes = {0};
  scene.nodes.push_back(node);
  SceneInstance instance;
  instance.node = 0, instance.mesh = 0, instance.material = 0;
  scene.instances.push_back(instance);
  return scene;
}

/// Counts the edges between welded world positions over the chosen meshes, and those that are open: a closed surface
/// has every edge as often in one direction as in the other.
template <class Chosen>
std::pair<size_t, size_t> count_edges(const Scene& scene, Chosen&& chosen) {
  using Key = std::array<float, 3>;
  std::map<std::pair<Key, Key>, int> balance;
  for (const SceneInstance& instance : scene.instances) {
    const Mesh& mesh = instance.shape(scene);
    if (!chosen(mesh)) continue;
    const auto key = [&](uint32_t v) {
      const glm::vec3 p(instance.world_from_object * glm::vec4(mesh.positions[v], 1.f));
      return Key{p.x + 0.f, p.y + 0.f, p.z + 0.f};
    };
    for (const glm::uvec3& t : mesh.triangles) {
      for (int i = 0; i < 3; ++i) {
        const Key a = key(t[i]), b = key(t[(i + 1) % 3]);
        if (a < b)
          ++balance[{a, b}];
        else
          --balance[{b, a}];
      }
    }
  }
  size_t open = 0;
  for (const auto& [edge, count] : balance) open += count != 0;
  return {balance.size(), open};
}

}  // namespace lucarium::test
