// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "virtual_light_field/tiles/tile_maps.h"

namespace lucarium::vlf {

/// For Technique::inspect(): the facet of a texel side, and how many tiles hold its light along the directions.
std::vector<std::pair<std::string, std::string>> describe_tiles(const TileMaps& maps, uint32_t side);

}  // namespace lucarium::vlf
