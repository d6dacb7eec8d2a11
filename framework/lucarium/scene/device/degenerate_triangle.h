// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <glm/glm.hpp>

#include "lucarium/scene/scene.h"
#include "lucarium/shared/scene_types.h"

namespace lucarium {

/// Whether a triangle has exactly no area. Rays never hit such a triangle (the BVH leaves it out), so that nothing may
/// count it as a surface either: no light leaves it and none arrives. Corners are world-space positions as the device
/// holds them [m]; edges and products are taken in double precision, and the products are compared, not subtracted.
inline bool is_degenerate(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
  const glm::dvec3 u = glm::dvec3(b) - glm::dvec3(a), v = glm::dvec3(c) - glm::dvec3(a);
  return u.y * v.z == u.z * v.y && u.z * v.x == u.x * v.z && u.x * v.y == u.y * v.x;
}
inline bool is_degenerate(const Vertex& a, const Vertex& b, const Vertex& c) {
  const auto point = [](const Vertex& v) { return glm::vec3(v.position.x, v.position.y, v.position.z); };
  return is_degenerate(point(a), point(b), point(c));
}

/// Triangles without area among those of all instances, at the evaluated time.
uint64_t degenerate_triangle_count(const Scene& scene);

}  // namespace lucarium
