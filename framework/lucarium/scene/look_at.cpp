// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/look_at.h"

#include <cmath>

namespace lucarium {

glm::mat4 frame_along(const glm::vec3& position, const glm::vec3& direction) {
  const glm::vec3 back = -glm::normalize(direction);
  const glm::vec3 up = std::abs(back.y) > 0.999f ? glm::vec3(0, 0, back.y > 0 ? -1 : 1) : glm::vec3(0, 1, 0);
  const glm::vec3 right = glm::normalize(glm::cross(up, back));
  return {glm::vec4(right, 0), glm::vec4(glm::cross(back, right), 0), glm::vec4(back, 0), glm::vec4(position, 1)};
}

SceneCamera look_at_camera(const std::string& name, const glm::vec3& eye, const glm::vec3& target, float yfov_degrees) {
  SceneCamera camera;
  camera.name = name;
  camera.yfov = glm::radians(yfov_degrees);
  camera.world_from_camera = frame_along(eye, target - eye);
  return camera;
}

}  // namespace lucarium
