// SPDX-License-Identifier: Apache-2.0
// A floor whose texels lie partly under glass: a sheet of index 1, which nobody sees, hovers above it. It blocks light
// samples, and what they miss comes through it otherwise: together as much as without the sheet.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "lucarium/scene/builtin/builder.h"
#include "lucarium/shared/texel_sides.h"
#include "made_scene.h"

namespace lucarium::test {

/// Of the scene below [m]: the sheet's height above the floor, and half of the edges of both.
inline constexpr float sheet_height = 0.05f, half_sheet = 0.5f, half_floor = 1.6f;
inline constexpr float sheet_albedo = 0.5f;  ///< of the floor

inline SceneMaterial invisible_glass() {
  SceneMaterial glass = clear_glass();
  glass.ior = 1;
  glass.thickness = 0;
  glass.double_sided = true;
  return glass;
}

/// Under a sky of radiance 1. `turned`: the sheet about the vertical [rad]; `height` [m] above the floor. The camera
/// looks down from below the sheet: 24 pixels of 10 cm. The floor is instance 0.
inline Scene invisible_sheet(float turned = 0, float height = sheet_height) {
  Scene scene;
  scene.environment = Environment{};
  scene.environment->factor = glm::vec3(1);
  const auto add_square = [&](float half, float y, float angle, const SceneMaterial& material) {
    const glm::vec3 x = half * glm::vec3(std::cos(angle), 0, std::sin(angle)), z(-x.z, 0, x.x), up(0, y, 0);
    add_polygon(scene, {up - x + z, up + x + z, up + x - z, up - x - z}, add_material(scene, material));
  };
  add_square(half_floor, 0, 0, lambert(sheet_albedo));
  add_square(half_sheet, height, turned, invisible_glass());
  SceneCamera camera;
  camera.name = "below";
  camera.perspective = false;
  camera.xmag = camera.ymag = 1.2f;
  camera.world_from_camera = frame_along({0, 0.5f * height, 0}, {0, -1, 0});
  scene.cameras.push_back(camera);
  return scene;
}

/// Mean over the rings of pixels on the inner and on the outer side of the sheet's edge, over what is right.
struct SheetRings {
  double inside = 0, outside = 0;
};
inline SheetRings sheet_rings(const std::vector<float>& image) {
  SheetRings sum, count;
  for (int y = 0; y < 24; ++y) {
    for (int x = 0; x < 24; ++x) {
      // The edge is 5 pixels from the middle.
      const int ring = std::max(std::max(x - 12, 11 - x), std::max(y - 12, 11 - y));
      const auto value = static_cast<double>(image[3 * (24 * static_cast<size_t>(y) + static_cast<size_t>(x))]);
      if (ring == 4) sum.inside += value / static_cast<double>(sheet_albedo), ++count.inside;
      if (ring == 5) sum.outside += value / static_cast<double>(sheet_albedo), ++count.outside;
    }
  }
  return {sum.inside / count.inside, sum.outside / count.outside};
}

/// Whether any point of a texel side that light reaches lies in its covered half, or in its open one. `levels`:
/// SideAccessibility::points().
inline bool half_has_point(uint32_t levels, bool covered) {
  for (uint32_t k = 0; k < SIDE_POINTS; ++k) {
    const uint32_t level = levels >> 4 * k & 15;
    if (level != 0 && (level >= 8) == covered) return true;
  }
  return false;
}

}  // namespace lucarium::test
