// SPDX-License-Identifier: Apache-2.0
#include "virtual_light_field/tiles/describe_tiles.h"

#include <fmt/format.h>

#include "lucarium/shared/scene_types.h"

namespace lucarium::vlf {

std::vector<std::pair<std::string, std::string>> describe_tiles(const TileMaps& maps, uint32_t side) {
  if (side == LUCARIUM_NONE || !maps.side_facet()) return {};
  const uint32_t facet = maps.side_facet().download(side, 1).front(), facets = maps.info().facets;
  if (facet >= facets) return {{"facet", "none: it reflects by Lambert's law, and its texel holds its light"}};
  const auto directions = static_cast<uint32_t>(maps.maps().count() / facets);
  uint32_t seen = 0;
  uint64_t tiles = 0;
  for (uint32_t direction = 0; direction < directions; ++direction) {
    const FieldMap map = maps.maps().download(size_t{direction} * facets + facet, 1).front();
    seen += FIELD_MAP_WIDTH(map) > 0 ? 1 : 0;
    tiles += uint64_t{FIELD_MAP_WIDTH(map)} * FIELD_MAP_HEIGHT(map);
  }
  return {{"facet", fmt::format("{} of {}", facet, facets)},
          {"directions with its light", fmt::format("{} of {}", seen, directions)},
          {"places for tiles on them", std::to_string(tiles)}};
}

}  // namespace lucarium::vlf
