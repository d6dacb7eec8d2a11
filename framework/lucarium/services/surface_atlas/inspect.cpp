// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/surface_atlas/inspect.h"

#include <fmt/format.h>

#include <glm/gtc/constants.hpp>

#include "lucarium/services/surface_atlas/layout/look_up.h"

namespace lucarium {

uint32_t side_at(const SurfaceAtlas& atlas, uint32_t triangle, float b1, float b2, bool front) {
  const AtlasTriangle record = atlas.triangles().download(triangle, 1).front();
  const uint32_t texel = atlas.table().download(atlas_cell(record, b1, b2), 1).front();
  if (front) return texel;
  const uint32_t two_sided = atlas.info().double_sided_count;
  return texel < two_sided ? texel + two_sided : LUCARIUM_NONE;
}

std::vector<std::pair<std::string, std::string>> describe_side(const SurfaceAtlas& atlas, uint32_t side,
                                                               const TypedBuffer<float4>& shown,
                                                               const std::string& name) {
  if (side == LUCARIUM_NONE) return {{"texel", "none: the back of a single-sided surface"}};
  const AtlasTexel texel = atlas.texels().download(side, 1).front();
  const float4 light = shown.download(side, 1).front();
  const glm::vec3 irradiance =
      light.w > 0 ? glm::vec3(light.x, light.y, light.z) * (glm::pi<float>() / light.w) : glm::vec3(0);
  return {{"texel side", fmt::format("{} of {}", side, atlas.info().texel_count)},
          {"its area", fmt::format("{:.4g} cm²", 1e4 * texel.area)},
          {"seen by light", fmt::format("{:.4g} %", 100 * light.w)},
          {name, fmt::format("{:.4g}  {:.4g}  {:.4g} lx", irradiance.x, irradiance.y, irradiance.z)}};
}

}  // namespace lucarium
