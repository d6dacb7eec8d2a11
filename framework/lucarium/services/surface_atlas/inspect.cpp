// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/surface_atlas/inspect.h"

#include <fmt/format.h>

#include <glm/gtc/constants.hpp>

#include "lucarium/services/surface_atlas/layout/look_up.h"

namespace lucarium {

namespace {

/// [lx]; `light`: over π and times w.
std::string irradiance_of(const float4& light) {
  const glm::vec3 value =
      light.w > 0 ? glm::vec3(light.x, light.y, light.z) * (glm::pi<float>() / light.w) : glm::vec3(0);
  return fmt::format("{:.4g}  {:.4g}  {:.4g} lx", value.x, value.y, value.z);
}

}  // namespace

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
  const uint32_t sides = atlas.info().texel_count;
  const float4 light = shown.download(side, 1).front();
  const bool halves = shown.count() > sides;
  const float4 covered = halves ? shown.download(size_t{sides} + side, 1).front() : float4{};
  std::vector<std::pair<std::string, std::string>> rows = {
      {"texel side", fmt::format("{} of {}", side, sides)},
      {"its area", fmt::format("{:.4g} cm²", 1e4 * texel.area)},
      {"seen by light", fmt::format("{:.4g} %", 100 * (light.w + covered.w))}};
  if (covered.w == 0 || light.w > 0) rows.emplace_back(name, irradiance_of(light));
  if (covered.w > 0) {
    rows.emplace_back("of it close under glass", fmt::format("{:.4g} %", 100 * covered.w));
    rows.emplace_back(name + " there", irradiance_of(covered));
  }
  return rows;
}

}  // namespace lucarium
