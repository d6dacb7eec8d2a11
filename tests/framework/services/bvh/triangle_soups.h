// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <glm/glm.hpp>
#include <random>
#include <vector>

#include "lucarium/shared/ray.h"
#include "lucarium/shared/scene_types.h"

namespace lucarium::test {

/// Triangles for intersection tests.
struct Soup {
  std::vector<Vertex> vertices;
  std::vector<Triangle> triangles;

  uint32_t add_vertex(const glm::vec3& p) {
    Vertex vertex;
    vertex.position = float4(p, 0.f);
    vertices.push_back(vertex);
    return static_cast<uint32_t>(vertices.size() - 1);
  }
  void add_triangle(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
    const uint32_t v0 = add_vertex(a), v1 = add_vertex(b), v2 = add_vertex(c);
    triangles.push_back({v0, v1, v2, 0});
  }
  glm::vec3 corner(uint32_t vertex) const { return vertices[vertex].position.xyz(); }
};

class Random {
 public:
  explicit Random(uint32_t seed) : engine_(seed) {}
  float uniform(float low = 0, float high = 1) { return std::uniform_real_distribution<float>(low, high)(engine_); }
  uint32_t below(uint32_t end) { return std::uniform_int_distribution<uint32_t>(0, end - 1)(engine_); }
  glm::vec3 in_cube(float half) { return {uniform(-half, half), uniform(-half, half), uniform(-half, half)}; }
  glm::vec3 direction() {
    const float z = uniform(-1, 1), angle = uniform(0, 6.2831853f), r = std::sqrt(std::max(0.f, 1 - z * z));
    return glm::normalize(glm::vec3(r * std::cos(angle), r * std::sin(angle), z));
  }

 private:
  std::mt19937 engine_;
};

/// Unconnected random triangles of very different sizes in a cube of the given half width.
inline Soup random_soup(uint32_t count, uint32_t seed, float half = 10) {
  Soup soup;
  Random random(seed);
  for (uint32_t i = 0; i < count; ++i) {
    const glm::vec3 center = random.in_cube(half);
    const float size = half * std::exp(random.uniform(-6, -0.5f));
    soup.add_triangle(center + random.in_cube(size), center + random.in_cube(size), center + random.in_cube(size));
  }
  return soup;
}

/// A closed star-shaped surface around the origin: a sphere of rings × segments with every vertex at a random radius
/// between 0.5 and 1.5, moved by `offset`; neighbours share vertices.
inline Soup rough_sphere(uint32_t rings, uint32_t segments, uint32_t seed, const glm::vec3& offset = glm::vec3(0)) {
  Soup soup;
  Random random(seed);
  const auto add = [&](float polar, float azimuth) {
    const glm::vec3 direction(std::sin(polar) * std::cos(azimuth), std::cos(polar),
                              std::sin(polar) * std::sin(azimuth));
    return soup.add_vertex(offset + random.uniform(0.5f, 1.5f) * direction);
  };
  const uint32_t top = add(0, 0), bottom = add(3.14159265f, 0), first = 2;
  for (uint32_t ring = 1; ring < rings; ++ring)
    for (uint32_t segment = 0; segment < segments; ++segment)
      add(3.14159265f * static_cast<float>(ring) / static_cast<float>(rings),
          6.2831853f * static_cast<float>(segment) / static_cast<float>(segments));
  const auto at = [&](uint32_t ring, uint32_t segment) { return first + (ring - 1) * segments + segment % segments; };
  for (uint32_t segment = 0; segment < segments; ++segment) {
    soup.triangles.push_back({top, at(1, segment + 1), at(1, segment), 0});
    soup.triangles.push_back({bottom, at(rings - 1, segment), at(rings - 1, segment + 1), 0});
    for (uint32_t ring = 1; ring + 1 < rings; ++ring) {
      soup.triangles.push_back({at(ring, segment), at(ring, segment + 1), at(ring + 1, segment), 0});
      soup.triangles.push_back({at(ring, segment + 1), at(ring + 1, segment + 1), at(ring + 1, segment), 0});
    }
  }
  return soup;
}

inline Ray make_ray(const glm::vec3& origin, const glm::vec3& direction, float length = INFINITY) {
  Ray ray;
  ray.origin = float4(origin, 0.f);
  ray.direction = float4(direction, length);
  return ray;
}

}  // namespace lucarium::test
