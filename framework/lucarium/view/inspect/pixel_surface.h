// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <string>

#include "lucarium/session/session.h"

namespace lucarium {

/// The first surface that is seen through the middle of a pixel.
struct PixelSurface {
  bool hit = false;
  float distance = 0;                                 ///< from the eye [m]
  glm::vec3 position{0}, normal{0}, shading{0};       ///< world space; towards the eye
  uint32_t instance = 0, triangle = 0, material = 0;  ///< indices; the triangle within its mesh
  std::string mesh, material_name;
  SeenPoint seen;  ///< the same for techniques
};

/// By a G-buffer of one pixel. `settings`: of the whole picture; (x, y) from the left and the top. Builds the scene's
/// BVH where no technique has asked for it yet.
PixelSurface find_pixel_surface(const std::shared_ptr<Device>& device, SceneOnDevice& scene,
                                const RenderSettings& settings, uint32_t x, uint32_t y);

}  // namespace lucarium
