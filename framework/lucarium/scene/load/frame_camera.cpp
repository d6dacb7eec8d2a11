// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/load/frame_camera.h"

#include <algorithm>
#include <cmath>

#include "lucarium/base/error.h"
#include "lucarium/scene/builtin/builder.h"
#include "lucarium/scene/load/load_scene.h"

namespace lucarium {

SceneCamera frame_camera(const Bounds& bounds, float aspect) {
  const glm::vec3 center = bounds.empty() ? glm::vec3(0) : bounds.center();
  const glm::vec3 extent = bounds.empty() ? glm::vec3(0) : bounds.max - bounds.min;
  const glm::vec3 back = glm::normalize(glm::vec3(0.6f, 0.45f, 1.f));
  SceneCamera camera = look_at_camera("framed", center + back, center, 40.f);
  camera.aspect = aspect;

  // The distance at which every corner of the box is inside the frame, with a margin of 5 %.
  const glm::vec3 right(camera.world_from_camera[0]), up(camera.world_from_camera[1]);
  const float tan_y = std::tan(0.5f * camera.yfov), tan_x = tan_y * aspect;
  float distance = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::vec3 d = extent * (glm::vec3(corner & 1, (corner >> 1) & 1, corner >> 2) - 0.5f);
    const float reach = 1.05f * std::max(std::abs(glm::dot(d, right)) / tan_x, std::abs(glm::dot(d, up)) / tan_y);
    distance = std::max(distance, glm::dot(d, back) + reach);
  }
  if (!(distance > 0)) distance = 1;
  camera.world_from_camera[3] = glm::vec4(center + distance * back, 1.f);
  return camera;
}

void require_light(const Scene& scene) {
  if (scene.has_light()) return;
  throw_error(ErrorClass::input,
              "{}: the scene has no light; give one with --environment FILE|R,G,B or --light point:X,Y,Z:R,G,B "
              "(docs/scenes.md)",
              scene.source);
}

}  // namespace lucarium
