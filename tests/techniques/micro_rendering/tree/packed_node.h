// SPDX-License-Identifier: Apache-2.0
// Nodes as the host reads them back.
#pragma once
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/packing.hpp>

#include "micro_rendering/shared/micro_types.h"

namespace lucarium::test {

/// Lengths in grid steps, angles in radians.
struct PackedNode {
  glm::vec3 center, normal;
  float radius, cone;
  glm::vec3 line;  ///< outward normal of the line where the surface ends; 0: none
  float reach;     ///< its distance from the centre
};

/// A point of the octahedron, unfolded to [-1, 1]^2, as a direction.
inline glm::vec3 unfold(const glm::vec2& p) {
  glm::vec3 n(p, 1 - std::abs(p.x) - std::abs(p.y));
  const float fold = std::max(-n.z, 0.f);
  n.x -= std::copysign(fold, n.x);
  n.y -= std::copysign(fold, n.y);
  return glm::normalize(n);
}

inline PackedNode unpack(const uint4& bits) {
  PackedNode node;
  node.center = glm::vec3(bits.x & 0xffffu, bits.x >> 16, bits.y & 0xffffu);
  node.radius = 2 * glm::unpackHalf1x16(static_cast<uint16_t>(bits.y >> 16));
  node.normal = unfold(glm::vec2(bits.z & 1023u, bits.z >> 10 & 1023u) / 511.f - 1.f);
  node.cone = static_cast<float>(bits.z >> 20 & 255u) * 3.14159265f / 255;
  const uint32_t steps = bits.w >> 16 & 255u;
  node.line = steps ? unfold(glm::vec2(bits.w & 255u, bits.w >> 8 & 255u) / 127.f - 1.f) : glm::vec3(0);
  node.reach = steps ? static_cast<float>(steps - 1) / 254 * node.radius : 0;
  return node;
}

}  // namespace lucarium::test
