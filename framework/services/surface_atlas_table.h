// SPDX-License-Identifier: Apache-2.0
// Parts joined to an atlas: internal to the surface atlas.
#pragma once
#include <span>

#include "lucarium/services/surface_atlas_chart.h"

namespace lucarium {

/// Numbers texels (double-sided ones first) and cells over all parts, in order, and writes the look-up records.
AtlasLayout join_parts(const AtlasMesh& mesh, std::span<const AtlasPart> parts, double edge);

/// Gives empty cells along smooth seams (dihedral angle below 60 degrees) the texels behind them, for interpolation.
void link_seams(const AtlasMesh& mesh, std::span<const AtlasPart> parts, AtlasLayout& layout);

}  // namespace lucarium
