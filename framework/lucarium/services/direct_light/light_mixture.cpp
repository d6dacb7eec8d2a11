// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/direct_light/light_mixture.h"

#include "lucarium/scene/device/light_list.h"
#include "lucarium/shared/light_tree.h"

namespace lucarium {

bool includes_light(const PathSet& set, uint32_t kind) {
  switch (kind) {
    case LUCARIUM_LIGHT_POINT: return set.point_lights;
    case LUCARIUM_LIGHT_SPOT: return set.spot_lights;
    case LUCARIUM_LIGHT_DIRECTIONAL: return set.directional_lights;
    case LUCARIUM_LIGHT_TRIANGLE: return set.emissive_triangles;
    default: return set.environment;
  }
}

std::vector<AliasEntry> make_light_mixture(const std::vector<Light>& lights, LightChoice choice, const PathSet& set) {
  return light_choice_table(lights, choice, [&set](const Light& light) { return includes_light(set, light.kind); });
}

std::vector<uint> make_light_trees(std::vector<uint> header, LightChoice choice, const PathSet& set) {
  for (uint32_t kind = 0; kind < LUCARIUM_LIGHT_KINDS; ++kind) {
    if (choice == LightChoice::tree && includes_light(set, kind)) continue;
    header[LUCARIUM_LIGHT_TREES_POWERS + kind] = 0;
    header[LUCARIUM_LIGHT_TREES_KINDS] &= ~(1u << kind);
  }
  return header;
}

}  // namespace lucarium
