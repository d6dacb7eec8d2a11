// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "lucarium/shared/scene_types.h"
#include "lucarium/shared/surface_atlas.h"

namespace lucarium {

/// The triangles that an atlas covers, world space.
struct AtlasGeometry {
  std::vector<glm::vec3> positions;    ///< per vertex [m]
  std::vector<glm::vec3> normals;      ///< per vertex, unit shading normals
  std::vector<glm::vec2> texcoord1;    ///< per vertex, or empty: then nothing is laid out by them
  std::vector<glm::uvec3> triangles;   ///< counter-clockwise seen from the front
  std::vector<uint32_t> instance;      ///< per triangle, ascending; surfaces of different instances never share a texel
  std::vector<uint8_t> two_sided;      ///< per instance: reflects or transmits on both sides
  std::vector<uint8_t> has_texcoord1;  ///< per instance: lay it out by TEXCOORD_1; empty: none
  std::vector<std::string> names;      ///< per instance, for messages; may be empty
};

/// How a layout is made. Either a wanted number of texel sides or a texel edge.
struct AtlasLayoutOptions {
  uint64_t texel_count =
      1'000'000;          ///< wanted texel sides (reflecting sides of texels); met within about 13 %, slivers aside
  double texel_edge = 0;  ///< [m]; above 0 it replaces texel_count
  double merge_threshold = 0.25;  ///< texels below this share of s² join a neighbour, 0: none do
  uint32_t samples = 0;           ///< random points per texel side (AtlasLayout::samples)
  unsigned threads = 0;           ///< 0: all of the machine. The result does not depend on it.
  std::function<void(double fraction, const std::string& stage)> progress;  ///< called from the building thread
  std::function<bool()> cancelled;  ///< asked often; when it says so, Error{interrupted} is thrown
};

/// A chart as the export shows it: a rectangle of cells in the table.
struct AtlasChart {
  uint32_t first_cell;     ///< in the table
  uint32_t width, height;  ///< [cells], a ring of one cell around the chart included; 1 × 1 for charts of one texel
};

/// An atlas as plain data. Texel sides and cells as in kernels/lucarium/shared/surface_atlas.h.
struct AtlasLayout {
  AtlasInfo info{};
  std::vector<AtlasTriangle> triangles;  ///< per world triangle
  std::vector<uint32_t> table;           ///< per cell: texel; cells that no triangle touches hold one that is near
  std::vector<uint8_t> links;            ///< per cell: LUCARIUM_ATLAS_LINK bits
  std::vector<AtlasTexel> texels;        ///< per texel side
  std::vector<uint2> ranges;             ///< per texel side: first and number of its pieces; backs share their front's
  std::vector<TexelPiece> pieces;
  std::vector<AtlasSample>
      samples;  ///< per texel side AtlasLayoutOptions::samples, uniform over its area; backs as fronts
  std::vector<AtlasChart> charts;
  std::vector<uint32_t> left_out;  ///< triangles that rays cannot hit: in no texel, they look up one beside them
};

/// Lays out an atlas of uniform world-space density s² = (area of all reflecting sides) / texel_count. Throws
/// Error{input} for TEXCOORD_1 that cannot be used and for atlases that 32-bit ids cannot name, Error{usage} for
/// options out of range, Error{interrupted} when cancelled.
AtlasLayout make_atlas_layout(const AtlasGeometry& geometry, const AtlasLayoutOptions& options);

}  // namespace lucarium
