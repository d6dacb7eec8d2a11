// SPDX-License-Identifier: Apache-2.0
// Closed bodies with closed forms.
#pragma once
#include <array>

#include "../../framework/services/bvh/triangle_soups.h"

namespace lucarium::test {

inline void append(Soup& soup, const Soup& more) {
  const auto first = static_cast<uint32_t>(soup.vertices.size());
  soup.vertices.insert(soup.vertices.end(), more.vertices.begin(), more.vertices.end());
  for (const Triangle& t : more.triangles) soup.triangles.push_back({first + t.v0, first + t.v1, first + t.v2, 0});
}

inline Soup placed(Soup soup, float scale, const glm::vec3& offset) {
  for (Vertex& v : soup.vertices) v.position = float4(scale * v.position.xyz() + offset, 0.f);
  return soup;
}

/// Points of a parametric surface that closes around both parameters.
template <class Point>
Soup surface(uint32_t rings, uint32_t segments, const Point& point) {
  Soup soup;
  for (uint32_t ring = 0; ring < rings; ++ring)
    for (uint32_t segment = 0; segment < segments; ++segment)
      soup.add_vertex(point(6.2831853f * static_cast<float>(ring) / static_cast<float>(rings),
                            6.2831853f * static_cast<float>(segment) / static_cast<float>(segments)));
  const auto at = [&](uint32_t ring, uint32_t segment) { return ring % rings * segments + segment % segments; };
  for (uint32_t ring = 0; ring < rings; ++ring)
    for (uint32_t segment = 0; segment < segments; ++segment) {
      soup.triangles.push_back({at(ring, segment), at(ring + 1, segment), at(ring + 1, segment + 1), 0});
      soup.triangles.push_back({at(ring, segment), at(ring + 1, segment + 1), at(ring, segment + 1), 0});
    }
  return soup;
}

/// Around the y axis, radii 1 and 0.4.
inline Soup torus() {
  return surface(160, 80, [](float around, float across) {
    const float r = 1 + 0.4f * std::cos(across);
    return glm::vec3(r * std::cos(around), 0.4f * std::sin(across), -r * std::sin(around));
  });
}

inline Soup sphere(const glm::vec3& center, float radius, uint32_t rings = 80) {
  Soup soup;
  const uint32_t segments = 2 * rings;
  const uint32_t top = soup.add_vertex(center + glm::vec3(0, radius, 0)),
                 bottom = soup.add_vertex(center - glm::vec3(0, radius, 0));
  for (uint32_t ring = 1; ring < rings; ++ring)
    for (uint32_t s = 0; s < segments; ++s) {
      const float polar = 3.14159265f * static_cast<float>(ring) / static_cast<float>(rings),
                  azimuth = 6.2831853f * static_cast<float>(s) / static_cast<float>(segments);
      soup.add_vertex(center + radius * glm::vec3(std::sin(polar) * std::cos(azimuth), std::cos(polar),
                                                  std::sin(polar) * std::sin(azimuth)));
    }
  const auto at = [&](uint32_t ring, uint32_t s) { return 2 + (ring - 1) * segments + s % segments; };
  for (uint32_t s = 0; s < segments; ++s) {
    soup.triangles.push_back({top, at(1, s + 1), at(1, s), 0});
    soup.triangles.push_back({bottom, at(rings - 1, s), at(rings - 1, s + 1), 0});
    for (uint32_t ring = 1; ring + 1 < rings; ++ring) {
      soup.triangles.push_back({at(ring, s), at(ring, s + 1), at(ring + 1, s), 0});
      soup.triangles.push_back({at(ring, s + 1), at(ring + 1, s + 1), at(ring + 1, s), 0});
    }
  }
  return soup;
}

inline Soup box(const glm::vec3& low, const glm::vec3& high) {
  Soup soup;
  for (uint32_t i = 0; i < 8; ++i)
    soup.add_vertex({i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z});
  for (const auto& [a, b, c, d] : {std::array{0u, 2u, 3u, 1u},
                                   {4u, 5u, 7u, 6u},
                                   {0u, 1u, 5u, 4u},
                                   {2u, 6u, 7u, 3u},
                                   {0u, 4u, 6u, 2u},
                                   {1u, 3u, 7u, 5u}}) {
    soup.triangles.push_back({a, b, c, 0});
    soup.triangles.push_back({a, c, d, 0});
  }
  return soup;
}

/// Sphere and torus, apart, turned off the axes.
inline Soup closed_bodies() {
  Soup soup = torus();
  append(soup, sphere({0.2f, 1.1f, 0.3f}, 0.6f));
  const glm::vec3 axis = glm::normalize(glm::vec3(1, 2, 3));
  for (Vertex& v : soup.vertices) {
    const glm::vec3 p = v.position.xyz();
    const float c = std::cos(0.7f), s = std::sin(0.7f);
    v.position = float4(c * p + s * glm::cross(axis, p) + (1 - c) * glm::dot(axis, p) * axis, 0.f);
  }
  return soup;
}

}  // namespace lucarium::test
