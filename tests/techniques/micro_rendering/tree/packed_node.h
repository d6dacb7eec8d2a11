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
};

inline PackedNode unpack(const uint4& bits) {
  PackedNode node;
  node.center = glm::vec3(bits.x & 0xffffu, bits.x >> 16, bits.y & 0xffffu);
  node.radius = 2 * glm::unpackHalf1x16(static_cast<uint16_t>(bits.y >> 16));
  const glm::vec2 p = glm::vec2(bits.z & 1023u, bits.z >> 10 & 1023u) / 511.f - 1.f;
  glm::vec3 n(p, 1 - std::abs(p.x) - std::abs(p.y));
  const float fold = std::max(-n.z, 0.f);
  n.x -= std::copysign(fold, n.x);
  n.y -= std::copysign(fold, n.y);
  node.normal = glm::normalize(n);
  node.cone = static_cast<float>(bits.z >> 20 & 255u) * 3.14159265f / 255;
  return node;
}

}  // namespace lucarium::test
