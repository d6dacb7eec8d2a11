// SPDX-License-Identifier: Apache-2.0
// The camera as kernels take it. Declared in scene_buffers.h.
#include <cmath>

#include "lucarium/scene/device/scene_buffers.h"

namespace lucarium {

Camera make_camera(const SceneCamera& camera, float aspect) {
  // glTF: a camera's node may be scaled, which does not change the view.
  const glm::mat4& m = camera.world_from_camera;
  const glm::vec3 right = glm::normalize(glm::vec3(m[0])), up = glm::normalize(glm::vec3(m[1]));
  const glm::vec3 forward = -glm::normalize(glm::vec3(m[2]));
  Camera result{};
  result.origin = float4(glm::vec3(m[3]), 0.f);
  result.direction = float4(forward, 0.f);
  if (camera.perspective) {
    const float half_height = std::tan(0.5f * camera.yfov);
    result.direction_dx = float4(half_height * aspect * right, 0.f);
    result.direction_dy = float4(half_height * up, 0.f);
  } else {
    result.origin_dx = float4(camera.ymag * aspect * right, 0.f);
    result.origin_dy = float4(camera.ymag * up, 0.f);
  }
  return result;
}

}  // namespace lucarium
