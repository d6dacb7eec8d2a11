// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/direct_light/light_mixture.h"

#include "lucarium/scene/device/alias_table.h"
#include "lucarium/scene/device/light_list.h"

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
  double power = 0, count = 0;
  for (const Light& light : lights)
    if (includes_light(set, light.kind)) {
      power += double{light.intensity.w};
      count += 1;
    }
  std::vector<double> weights;
  for (const Light& light : lights) {
    const bool even = choice == LightChoice::uniform || !(power > 0);
    const double by_power = even ? 0 : double{light.intensity.w} / power;
    const double share = even ? 1 : even_light_share;
    weights.push_back(includes_light(set, light.kind) ? (1 - share) * by_power + share / count : 0.0);
  }
  return make_alias_table(weights);
}

}  // namespace lucarium
