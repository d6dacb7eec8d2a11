// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <glm/glm.hpp>
#include <vector>

namespace lucarium::test {

/// Lambert's formula: what a polygon of radiance 1 sends to a point with normal n, all of it in front.
inline double polygon_irradiance(const glm::dvec3& point, const glm::dvec3& n, const std::vector<glm::dvec3>& corners) {
  double sum = 0;
  for (size_t i = 0; i < corners.size(); ++i) {
    const glm::dvec3 a = glm::normalize(corners[i] - point);
    const glm::dvec3 b = glm::normalize(corners[(i + 1) % corners.size()] - point);
    sum += std::acos(glm::dot(a, b)) * glm::dot(glm::normalize(glm::cross(a, b)), n);
  }
  return std::abs(sum) / 2;
}

}  // namespace lucarium::test
