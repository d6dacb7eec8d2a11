// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <glm/glm.hpp>
#include <string>

#include "lucarium/scene/scene.h"

namespace lucarium {

/// A camera at `eye` that looks at `target`; yfov in degrees.
SceneCamera look_at_camera(const std::string& name, const glm::vec3& eye, const glm::vec3& target, float yfov_degrees);

/// Places a light's or camera's frame: at `position`, looking (shining) along `direction`, up as near to +Y as can be.
glm::mat4 frame_along(const glm::vec3& position, const glm::vec3& direction);

}  // namespace lucarium
