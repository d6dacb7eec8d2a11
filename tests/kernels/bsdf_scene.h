// SPDX-License-Identifier: Apache-2.0
// One triangle in the plane z = 0, facing +z, per material: material i is world triangle i.
#pragma once
#include <string>
#include <vector>

#include "kernel_fixture.h"

namespace lucarium::test {

struct NamedMaterial {
  std::string name;
  SceneMaterial material;
  glm::vec3 shading_normal{0, 0, 1};
};

inline SceneMaterial dielectric(float base, float roughness, float ior = 1.5f) {
  SceneMaterial m;
  m.base_color = glm::vec4(base, base, base, 1);
  m.metallic = 0, m.roughness = roughness, m.ior = ior, m.double_sided = true;
  return m;
}
inline SceneMaterial metal(float base, float roughness) {
  SceneMaterial m = dielectric(base, roughness);
  m.metallic = 1;
  return m;
}
inline SceneMaterial glass(float base, float roughness, float transmission, bool volume, float ior = 1.5f) {
  SceneMaterial m = dielectric(base, roughness, ior);
  m.transmission = transmission;
  m.thickness = volume ? 1.f : 0.f;
  m.double_sided = false;  // transmissive surfaces are two-sided all the same
  return m;
}

inline Scene material_scene(const std::vector<NamedMaterial>& materials) {
  Scene scene;
  scene.source = "test";
  for (const NamedMaterial& m : materials) {
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.normals.assign(3, glm::normalize(m.shading_normal));
    mesh.triangles = {{0, 1, 2}};
    mesh.material = static_cast<int>(scene.materials.size());
    SceneInstance instance;
    instance.mesh = static_cast<int>(scene.meshes.size());
    instance.material = mesh.material;
    scene.meshes.push_back(std::move(mesh));
    scene.materials.push_back(m.material);
    scene.instances.push_back(instance);
  }
  return scene;
}

/// Kernels of bsdf.cl over such a scene.
class BsdfProbe {
 public:
  explicit BsdfProbe(const std::vector<NamedMaterial>& materials,
                     const std::map<std::string, std::string>& defines = {})
      : BsdfProbe(material_scene(materials), defines) {}
  explicit BsdfProbe(const Scene& scene, const std::map<std::string, std::string>& defines = {})
      : buffers_(*test_device(), scene), program_(kernel_program("bsdf", defines)) {}

  /// Binds the scene and what `bind` gives.
  template <class Bind>
  void run(const std::string& kernel, size_t items, size_t group, Bind bind) const {
    run_kernel(program_, kernel, items, group, [&](PassBuilder& pass) {
      buffers_.bind(pass);
      bind(pass);
    });
  }

  struct Samples {
    std::vector<float4> directions, weights;
  };
  /// `replicates` 1: random numbers; more: that many Sobol sets, interleaved.
  Samples sample(uint triangle, const glm::vec3& view, uint count, uint seed, uint replicates = 1,
                 uint options = 0) const {
    const auto directions = test_buffer<float4>(count), weights = test_buffer<float4>(count);
    run("sample_directions", count, 64, [&](PassBuilder& pass) {
      pass.arg("triangle", triangle).arg("view", float4(view, 0.f)).arg("options", options).arg("seed", seed);
      pass.arg("replicates", replicates).arg("count", count).arg("directions", directions).arg("weights", weights);
    });
    return {directions.download(), weights.download()};
  }

  float4 evaluate(uint triangle, const glm::vec3& view, const glm::vec3& light, uint options = 0) const {
    const auto value = test_buffer<float4>(1);
    run("evaluate_pair", 1, 1, [&](PassBuilder& pass) {
      pass.arg("triangle", triangle).arg("view", float4(view, 0.f)).arg("light", float4(light, 0.f));
      pass.arg("options", options).arg("value", value);
    });
    return value.download()[0];
  }

  const SceneBuffers& buffers() const { return buffers_; }

 private:
  SceneBuffers buffers_;
  Program program_;
};

inline glm::vec3 direction_at(double cosine, double turns) {
  const double s = std::sqrt(std::max(0.0, 1 - cosine * cosine)), phi = 2 * 3.14159265358979323846 * turns;
  return glm::vec3(s * std::cos(phi), s * std::sin(phi), cosine);
}

}  // namespace lucarium::test
