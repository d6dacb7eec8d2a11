// SPDX-License-Identifier: Apache-2.0
// Surfaces as kernels make them, of hits that a test invents.
#pragma once
#include <cstring>
#include <vector>

#include "kernel_fixture.h"
#include "lucarium/shared/ray.h"

namespace lucarium::test {

inline const Program& surface_program() {
  static const Program instance = kernel_program("surface");
  return instance;
}

struct SurfaceResult {
  float4 position_material, n_g_flags, n_s_offset, uvs, color, base, origin_on, origin_back;
};

inline std::vector<SurfaceResult> make_surfaces(const SceneBuffers& buffers, const std::vector<Hit>& hits,
                                                const glm::vec3& direction, uint options = 0) {
  const auto device_hits = test_buffer(hits);
  const auto results = test_buffer<float4>(8 * hits.size());
  run_kernel(surface_program(), "make_surfaces", hits.size(), 1, [&](PassBuilder& pass) {
    buffers.bind(pass);
    pass.arg("hits", device_hits).arg("direction", float4(direction, 0.f)).arg("options", options);
    pass.arg("count", static_cast<uint>(hits.size())).arg("results", results);
  });
  const auto values = results.download();
  std::vector<SurfaceResult> list(hits.size());
  std::memcpy(static_cast<void*>(list.data()), values.data(), values.size() * sizeof(float4));
  return list;
}

inline Hit hit_at(uint triangle, float u, float v) {
  Hit hit{};
  hit.distance = 1, hit.triangle = triangle, hit.u = u, hit.v = v;
  return hit;
}

/// A triangle in z = 0 that faces +z, with every attribute, under `matrix`.
inline Scene attribute_scene(const glm::mat4& matrix = glm::mat4(1.f)) {
  Scene scene;
  scene.source = "test";
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.normals = {glm::normalize(glm::vec3(0.2f, 0, 1)), glm::normalize(glm::vec3(0, 0.2f, 1)), {0, 0, 1}};
  mesh.tangents.assign(3, glm::vec4(1, 0, 0, 1));
  mesh.uv[0] = {{0.1f, 0.2f}, {0.9f, 0.3f}, {0.2f, 0.8f}};
  mesh.uv[1] = {{1, 2}, {3, 4}, {5, 6}};
  mesh.colors = {{1, 0, 0, 1}, {0, 1, 0, 0.5f}, {0, 0, 1, 0.25f}};
  mesh.triangles = {{0, 1, 2}};
  scene.meshes.push_back(mesh);
  scene.materials.emplace_back();
  SceneInstance instance;
  instance.mesh = 0, instance.material = 0;
  instance.world_from_object = matrix;
  scene.instances.push_back(instance);
  return scene;
}

inline bool near(const glm::vec3& a, const glm::vec3& b, float tolerance = 1e-5f) {
  return glm::distance(a, b) <= tolerance;
}

}  // namespace lucarium::test
