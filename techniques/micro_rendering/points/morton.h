// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstdint>
#include <glm/vec3.hpp>

namespace lucarium::micro {

/// 30-bit Morton code of a point of the unit cube; what lies outside is moved to its surface.
inline uint32_t morton_code(const glm::vec3& p) {
  uint32_t code = 0;
  for (int axis = 0; axis < 3; ++axis) {
    auto x = static_cast<uint32_t>(std::clamp(p[axis] * 1024.f, 0.f, 1023.f));
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    x = (x | x << 2) & 0x09249249u;
    code |= x << axis;
  }
  return code;
}

}  // namespace lucarium::micro
