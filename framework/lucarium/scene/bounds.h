// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

namespace lucarium {

/// Axis-aligned box [m]; empty when min > max.
struct Bounds {
  glm::vec3 min{1e30f}, max{-1e30f};
  bool empty() const { return min.x > max.x; }
  void add(const glm::vec3& p) { min = glm::min(min, p), max = glm::max(max, p); }
  void add(const Bounds& b) { min = glm::min(min, b.min), max = glm::max(max, b.max); }
  glm::vec3 center() const { return 0.5f * (min + max); }
  float radius() const { return empty() ? 0.f : 0.5f * glm::length(max - min); }
  /// Half the area of its surface; 0 when empty.
  float half_area() const {
    const glm::vec3 size = max - min;
    return size.x < 0 ? 0.f : size.x * size.y + size.y * size.z + size.z * size.x;
  }
  /// 0 when empty.
  float longest_side() const { return empty() ? 0.f : glm::max(max.x - min.x, glm::max(max.y - min.y, max.z - min.z)); }
  /// Largest absolute coordinate; 0 when empty.
  float extent() const {
    float largest = 0;
    for (int axis = 0; axis < 3 && min[axis] <= max[axis]; ++axis)
      largest = std::max({largest, std::fabs(min[axis]), std::fabs(max[axis])});
    return largest;
  }
};

}  // namespace lucarium
