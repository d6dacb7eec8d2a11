// SPDX-License-Identifier: Apache-2.0
// Parts joined to an atlas: internal to the surface atlas.
#pragma once
#include <span>

#include "lucarium/services/surface_atlas/layout/chart.h"

namespace lucarium {

/// Lets charts of one texel below merge_threshold · s² join the texel of another chart that they touch: at most 1.5 s²
/// and 2 s from its sample position, normals within 75 degrees.
void absorb_fragments(const AtlasMesh& mesh, const ChartSettings& settings, std::vector<AtlasPart>& parts);

/// Texel sides that these parts make; of them those of slivers, less than s²/64 in area, and their area.
struct SideCount {
  uint64_t all = 0, slivers = 0;
  double sliver_area = 0;  ///< [m²]
};
SideCount side_count(std::span<const AtlasPart> parts, double edge);

/// Numbers texels (double-sided ones first) and cells over all parts, in order, and writes the look-up records.
AtlasLayout join_parts(const AtlasMesh& mesh, std::span<const AtlasPart> parts, double edge);

/// Gives empty cells along smooth seams (dihedral angle below 60 degrees) the texels behind them, for interpolation.
void link_seams(const AtlasMesh& mesh, std::span<const AtlasPart> parts, AtlasLayout& layout);

/// Fills AtlasLayout::left_out and gives those triangles a texel to look up: that of a triangle which they touch, else
/// of the first one in their instance, else of the first of all.
void place_left_out(const AtlasMesh& mesh, AtlasLayout& layout);

/// Gives the cells that are still empty the texel of the nearest one (in steps along the axes), so that no look-up,
/// however coarsely uv was interpolated, finds nothing.
void fill_empty_cells(AtlasLayout& layout);

/// Fills AtlasLayout::samples, `count` per side.
void sample_texels(const AtlasMesh& mesh, AtlasLayout& layout, uint32_t count);

}  // namespace lucarium
