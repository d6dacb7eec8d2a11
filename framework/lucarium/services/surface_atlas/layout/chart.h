// SPDX-License-Identifier: Apache-2.0
// From a set of triangles to placed charts: internal to the surface atlas.
#pragma once
#include <vector>

#include "lucarium/services/surface_atlas/layout/mesh.h"

namespace lucarium {

/// A triangle of a chart with its corners in the chart's plane: first [m], then cells (a ring of one cell around).
struct ChartTriangle {
  uint32_t triangle;
  glm::dvec2 uv[3];
};

/// The part of triangle number `local` of a chart that lies in a cell.
struct ChartPiece {
  uint32_t cell;  ///< y · width + x
  uint32_t local;
  float fraction;  ///< of the triangle's area
  float b1, b2;    ///< centroid
};

struct PlacedChart {
  uint32_t first_triangle, triangle_count;  ///< in AtlasPart::triangles
  uint32_t first_cell, width, height;       ///< in AtlasPart::cells; 1 × 1: one texel, constant uv
  uint32_t first_texel, texel_count;        ///< in AtlasPart::texels
  bool two_sided;
  /// Where absorb_fragments() made it part of another chart's texel: that chart's part and cell.
  uint32_t absorbed_by = LUCARIUM_NONE, absorbing_cell = LUCARIUM_NONE;
};

/// A texel of some part.
struct TexelPlace {
  uint32_t part, texel;
};

struct PartTexel {
  uint32_t triangle;
  float b1, b2;
  double area;  ///< of one side [m²], what it absorbed included
  uint32_t first_piece, piece_count;
  std::vector<TexelPlace> extra = {};  ///< absorbed ones, whose pieces are its own
};

/// Some finished charts. Parts are made independently and joined in order, so that the number of threads cannot matter.
struct AtlasPart {
  std::vector<PlacedChart> charts;
  std::vector<ChartTriangle> triangles;
  std::vector<uint32_t> cells;  ///< texel of the part or LUCARIUM_NONE
  std::vector<uint8_t> links;
  std::vector<PartTexel> texels;
  std::vector<TexelPiece> pieces;
};

/// What all charts of one atlas share.
struct ChartSettings {
  double edge;                         ///< s [m]
  double merge_threshold;              ///< share of s²
  std::vector<double> texcoord_scale;  ///< per instance: metres per unit of TEXCOORD_1; 0 or empty: projected
};

/// Root of a union-find forest, halving paths.
inline uint32_t find_root(std::vector<uint32_t>& parent, uint32_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

/// Lays sets of triangles out as charts of cells and texels, one after the other.
class ChartPlacer {
 public:
  ChartPlacer(const AtlasMesh& mesh, const ChartSettings& settings);

  /// Places the triangles of one chart, as several where its shape or its texels require it. `one_texel`: they are
  /// known to share a single texel.
  void place(const std::vector<uint32_t>& triangles, bool one_texel, AtlasPart& part);

 private:
  // surface_atlas_place.cpp
  bool is_one_texel(const std::vector<uint32_t>& triangles) const;
  void place_one_texel(const std::vector<uint32_t>& triangles, AtlasPart& part) const;
  void place_grid(AtlasPart& part);
  void queue_parts(const std::vector<uint32_t>& triangles);
  // surface_atlas_project.cpp
  bool project(const std::vector<uint32_t>& triangles);
  bool bisect(std::vector<uint32_t>& one, std::vector<uint32_t>& other) const;
  void fit_grid();
  // cells.cpp
  void cut_into_cells();
  void eject(std::vector<uint32_t>& ejected);
  bool split_cell(uint32_t first, uint32_t last, std::vector<uint8_t>& is_ejected, uint32_t keep);
  uint32_t connect_pieces(const std::vector<uint32_t>& alive);
  void index_cells();
  // surface_atlas_texels.cpp
  void measure_cells();
  uint32_t neighbor_cell(uint32_t c, int dx, int dy) const;
  bool cells_share_triangle(uint32_t a, uint32_t b, bool with_area) const;
  void merge_small_cells();
  uint32_t home_of_touched(uint32_t c);
  void assign_touched_cells();
  void number_texels(AtlasPart& part);
  void link_cells(AtlasPart& part) const;

  const AtlasMesh& mesh_;
  const ChartSettings& settings_;
  std::vector<std::vector<uint32_t>> queue_;
  // The chart at hand:
  std::vector<ChartTriangle> chart_;
  glm::dvec2 size_{0};  ///< of its rectangle [m]
  uint32_t width_ = 0, height_ = 0;
  std::vector<ChartPiece> pieces_;     ///< by cell, then by triangle
  std::vector<uint32_t> covered_;      ///< cells that have pieces, ascending
  std::vector<uint32_t> first_piece_;  ///< of each covered cell, and the end
  std::vector<uint32_t> index_;        ///< per cell: its place in covered_ or LUCARIUM_NONE
  std::vector<double> cell_area_;      ///< per covered cell; of a representative: of all that joined it
  std::vector<uint32_t> texel_of_;     ///< per covered cell: union-find, then the number of its texel
  std::vector<uint32_t> place_;  ///< per triangle of the mesh: index in the set at hand; LUCARIUM_NONE between uses
  // Scratch:
  std::vector<uint32_t> parent_, alive_;
  std::vector<std::pair<uint64_t, uint32_t>> keys_;
};

}  // namespace lucarium
