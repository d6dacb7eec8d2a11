// SPDX-License-Identifier: Apache-2.0
// Scenes of single lights, what tests/kernels/lights.cl samples and meets in them, and scenes of many lights.
#pragma once
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>
#include <random>
#include <vector>

#include "kernel_fixture.h"
#include "lucarium/base/numbers.h"
#include "made_scene.h"

namespace lucarium::test {

inline constexpr uint all_kinds = 31;

inline const Program& light_program() {
  static const Program instance = kernel_program("lights");
  return instance;
}

inline SceneMaterial two_sided(SceneMaterial material) {
  material.double_sided = true;
  return material;
}

inline void add_triangle(Scene& scene, const SceneMaterial& material, const glm::vec3& a, const glm::vec3& b,
                         const glm::vec3& c) {
  Mesh mesh;
  mesh.positions = {a, b, c};
  mesh.normals.assign(3, glm::normalize(glm::cross(b - a, c - a)));
  mesh.uv[0] = {{0, 0}, {1, 0}, {0, 1}};
  mesh.triangles = {{0, 1, 2}};
  SceneInstance instance;
  instance.mesh = static_cast<int>(scene.meshes.size());
  instance.material = static_cast<int>(scene.materials.size());
  scene.meshes.push_back(mesh);
  scene.materials.push_back(material);
  scene.instances.push_back(instance);
}

inline Scene empty_scene() {
  Scene scene;
  scene.source = "test";
  return scene;
}

/// 32 x 16 texels, many black, one 3000 times the others, turned in all axes.
inline Scene environment_scene() {
  Scene scene = empty_scene();
  Environment e;
  e.width = 32, e.height = 16;
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (uint32_t i = 0; i < e.width * e.height; ++i) {
    const uint32_t column = i % e.width, row = i / e.width;
    const bool black = (column > 8 && column < 17) || (row > 10 && column < 22) || row < 2;
    e.radiance.push_back(black ? glm::vec3(0) : glm::vec3(uniform(random), uniform(random), uniform(random)));
  }
  e.radiance[5 * e.width + 27] = glm::vec3(3000, 2000, 1000);
  e.factor = glm::vec3(1, 2, 0.5f);
  e.environment_from_world = glm::mat3(glm::mat4_cast(glm::normalize(glm::quat(0.8f, 0.3f, -0.4f, 0.2f))));
  scene.environment = e;
  return scene;
}

struct LightSamples {
  std::vector<float4> directions, radiances, ends;
};

/// `ray_seed`: of the shadow rays, LUCARIUM_SEED_OPAQUE or another.
inline LightSamples sample(const SceneBuffers& buffers, const glm::vec3& position, uint count, uint kinds = all_kinds,
                           uint seed = 1, uint ray_seed = 1) {
  const auto directions = test_buffer<float4>(count), radiances = test_buffer<float4>(count),
             ends = test_buffer<float4>(count);
  run_kernel(light_program(), "sample_lights", count, 64, [&](PassBuilder& pass) {
    buffers.bind(pass);
    pass.arg("position", float4(position, 0.f)).arg("kinds", kinds).arg("seed", seed).arg("count", count);
    pass.arg("ray_seed", ray_seed);
    pass.arg("directions", directions).arg("radiances", radiances).arg("ends", ends);
  });
  return {directions.download(), radiances.download(), ends.download()};
}

/// Radiance (xyz) and density (w) met along the directions from a point.
inline std::vector<float4> meet(const SceneBuffers& buffers, const glm::vec3& position,
                                const std::vector<float4>& directions) {
  const auto rays = test_buffer(directions), values = test_buffer<float4>(directions.size());
  run_kernel(light_program(), "meet_lights", directions.size(), 64, [&](PassBuilder& pass) {
    buffers.bind(pass);
    pass.arg("position", float4(position, 0.f)).arg("directions", rays);
    pass.arg("count", static_cast<uint>(directions.size())).arg("values", values);
  });
  return values.download();
}

// ---- many lights at random, and points among them

/// A point to be lit, from one side where it has a normal.
struct Lit {
  glm::vec3 position, normal;
  float4 place() const { return {position, 0.f}; }
  float4 side() const { return {normal, normal == glm::vec3(0) ? 0.f : 1.f}; }
};

class Random {
 public:
  explicit Random(uint seed) : engine_(seed) {}
  float number(float from, float to) { return std::uniform_real_distribution<float>(from, to)(engine_); }
  glm::vec3 point(float extent) {
    const float x = number(-extent, extent), y = number(-extent, extent), z = number(-extent, extent);
    return {x, y, z};
  }
  glm::vec3 direction() {
    for (;;) {
      const glm::vec3 p = point(1);
      if (glm::length(p) > 0.1f && glm::length(p) < 1) return glm::normalize(p);
    }
  }

 private:
  std::mt19937 engine_;
};

inline void add_random_triangles(Scene& scene, Random& random, int count) {
  for (int i = 0; i < count; ++i) {
    const glm::vec3 center = random.point(5);
    const glm::vec3 a = center + random.point(0.4f), b = center + random.point(0.4f), c = center + random.point(0.4f);
    const SceneMaterial material = emitter(std::exp(random.number(-2, 2)));
    // Every ninth is a sliver whose corners lie in a row up to rounding.
    add_triangle(scene, i % 5 == 0 ? two_sided(material) : material, a, b, i % 9 == 4 ? a + 0.37f * (b - a) : c);
    if (i % 7 == 1) scene.instances.back().world_from_object = glm::scale(glm::mat4(1.f), glm::vec3(-1, 1, 1));
    if (i % 7 == 2) scene.instances.back().mirrored = true;
  }
}

inline void add_random_lights(Scene& scene, Random& random, LightType type, int count) {
  for (int i = 0; i < count; ++i) {
    const glm::vec3 position = random.point(5);
    add_light(scene, type, std::exp(random.number(-2, 2)), position, position + random.direction());
    scene.lights.back().inner_angle = random.number(0, 0.4f);
    scene.lights.back().outer_angle = scene.lights.back().inner_angle + random.number(0.05f, 1.1f);
  }
}

/// Lights of all kinds, so many that their trees have several levels.
inline Scene many_lights(uint seed = 11) {
  Scene scene = empty_scene();
  Random random(seed);
  add_random_triangles(scene, random, 90);
  add_random_lights(scene, random, LightType::point, 20);
  add_random_lights(scene, random, LightType::spot, 70);
  add_random_lights(scene, random, LightType::directional, 3);
  set_environment(scene, 0.02f);
  return scene;
}

/// Every other one is lit from one side.
inline std::vector<Lit> points_among(uint seed, int count) {
  Random random(seed);
  std::vector<Lit> points;
  for (int i = 0; i < count; ++i) {
    const glm::vec3 position = random.point(i % 3 == 0 ? 12.f : 5.f), normal = random.direction();
    points.push_back({position, i % 2 ? normal : glm::vec3(0)});
  }
  return points;
}

}  // namespace lucarium::test
