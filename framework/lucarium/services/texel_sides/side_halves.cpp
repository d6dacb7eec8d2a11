// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/texel_sides/side_halves.h"

#include <algorithm>

#include "lucarium/scene/scene.h"

namespace lucarium {

std::map<std::string, std::string> SideHalves::defines() const {
  return two() ? std::map<std::string, std::string>{{"SIDE_HALVES", ""}} : std::map<std::string, std::string>{};
}

uint32_t SideHalves::per_side(const Scene& scene, float access_gap) {
  const bool glass = std::any_of(scene.materials.begin(), scene.materials.end(),
                                 [](const SceneMaterial& m) { return m.transmission > 0; });
  return glass && access_gap != 0 ? 2 : 1;
}

}  // namespace lucarium
