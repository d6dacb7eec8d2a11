// SPDX-License-Identifier: Apache-2.0
// Scenes of many lights at random, and points among them.
#pragma once
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <random>
#include <vector>

#include "light_scenes.h"

namespace lucarium::test {

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
