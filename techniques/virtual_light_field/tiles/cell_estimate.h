// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <vector>

#include "lucarium/scene/scene.h"
#include "virtual_light_field/tiles/patches.h"

namespace lucarium::vlf {

/// What TileMaps is expected to find, all directions together.
struct CellCounts {
  double cells = 0, tiles = 0, entries = 0;  ///< as TileMaps; entries: of tile_cells
  double maps = 0;
  double coarse_cells = 0;  ///< of the cells, those of facets with a level
};

/// Counts them on the subfields of few directions, as build_maps.cl does. `tiled`: per instance, 1 where it keeps
/// radiance by direction; `texel_edge`: of the atlas to come [m]; `subfield`: N.
CellCounts expect_cells(const Scene& scene, const std::vector<uint8_t>& tiled, const PatchOptions& options,
                        double texel_edge, uint32_t subfield, uint32_t dir_n);

}  // namespace lucarium::vlf
