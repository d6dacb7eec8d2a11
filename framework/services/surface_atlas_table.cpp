// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/surface_atlas_table.h"

#include <cmath>

#include "lucarium/base/error.h"

namespace lucarium {

namespace {

/// uv relative to the triangle's integer minimum, which goes into the base.
AtlasTriangle make_record(const ChartTriangle& triangle, const PlacedChart& chart, uint32_t first_cell) {
  const glm::dvec2 minimum = glm::floor(glm::min(triangle.uv[0], glm::min(triangle.uv[1], triangle.uv[2])));
  AtlasTriangle record{};
  float* const corner = &record.u0;
  for (int i = 0; i < 3; ++i) {
    corner[2 * i] = static_cast<float>(triangle.uv[i].x - minimum.x);
    corner[2 * i + 1] = static_cast<float>(triangle.uv[i].y - minimum.y);
  }
  const bool one_texel = chart.width == 1;
  record.pitch = one_texel ? 0 : chart.width;
  record.base = first_cell + static_cast<uint32_t>(minimum.y) * record.pitch + static_cast<uint32_t>(minimum.x);
  return record;
}

/// Where the texels of one chart go.
class Joiner {
 public:
  Joiner(AtlasLayout& layout, uint32_t double_sided) : layout_(layout), next_single_(2 * double_sided) {}

  void add(const AtlasPart& part, const PlacedChart& chart) {
    uint32_t& next = chart.two_sided ? next_double_ : next_single_;
    const uint32_t first_cell = static_cast<uint32_t>(layout_.table.size());
    const size_t cells = size_t{chart.width} * chart.height;
    layout_.charts.push_back({first_cell, chart.width, chart.height});
    for (size_t i = chart.first_cell; i < chart.first_cell + cells; ++i) {
      const bool empty = part.cells[i] == LUCARIUM_NONE;
      layout_.table.push_back(empty ? LUCARIUM_NONE : part.cells[i] - chart.first_texel + next);
      layout_.links.push_back(part.links[i]);
    }
    for (uint32_t i = chart.first_triangle; i < chart.first_triangle + chart.triangle_count; ++i)
      layout_.triangles[part.triangles[i].triangle] = make_record(part.triangles[i], chart, first_cell);
    for (uint32_t i = chart.first_texel; i < chart.first_texel + chart.texel_count; ++i) {
      const PartTexel& texel = part.texels[i];
      const AtlasTexel record{texel.triangle, texel.b1, texel.b2, static_cast<float>(texel.area)};
      const uint2 range{static_cast<uint32_t>(layout_.pieces.size()), texel.piece_count};
      const auto piece = part.pieces.begin() + texel.first_piece;
      layout_.pieces.insert(layout_.pieces.end(), piece, piece + texel.piece_count);
      for (uint32_t slot = next;; slot += layout_.info.double_sided_count) {
        layout_.texels[slot] = record;
        layout_.ranges[slot] = range;
        if (!chart.two_sided || slot != next) break;
      }
      ++next;
    }
  }

 private:
  AtlasLayout& layout_;
  uint32_t next_double_ = 0, next_single_;
};

}  // namespace

AtlasLayout join_parts(const AtlasMesh& mesh, std::span<const AtlasPart> parts, double edge) {
  uint64_t single = 0, both = 0, cells = 0, pieces = 0, charts = 0;
  for (const AtlasPart& part : parts) {
    for (const PlacedChart& chart : part.charts) (chart.two_sided ? both : single) += chart.texel_count;
    cells += part.cells.size();
    pieces += part.pieces.size();
    charts += part.charts.size();
  }
  if (std::max({cells, pieces, single + 2 * both}) >= LUCARIUM_NONE / 2) {
    throw_error(ErrorClass::usage, "surface atlas: {} slots in {} cells are more than 32-bit ids can name; ask for fewer texels",
                single + 2 * both, cells);
  }
  AtlasLayout layout;
  layout.info = {static_cast<uint32_t>(single + 2 * both), static_cast<uint32_t>(both), static_cast<uint32_t>(cells),
                 static_cast<float>(edge)};
  layout.triangles.resize(mesh.triangle_count());
  layout.table.reserve(cells);
  layout.links.reserve(cells);
  layout.texels.resize(layout.info.texel_count);
  layout.ranges.resize(layout.info.texel_count);
  layout.pieces.reserve(pieces);
  layout.charts.reserve(charts);
  Joiner joiner(layout, layout.info.double_sided_count);
  for (const AtlasPart& part : parts)
    for (const PlacedChart& chart : part.charts) joiner.add(part, chart);
  return layout;
}

}  // namespace lucarium
