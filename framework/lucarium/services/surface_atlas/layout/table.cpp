// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/surface_atlas/layout/table.h"

#include <algorithm>
#include <cmath>

#include "lucarium/base/error.h"
#include "lucarium/services/surface_atlas/layout/look_up.h"

namespace lucarium {

namespace {

constexpr double sliver_area = 1. / 64;  // of a texel [s²]

/// uv relative to the triangle's integer minimum, which goes into the base.
AtlasTriangle make_record(const ChartTriangle& triangle, const PlacedChart& chart, uint32_t first_cell,
                          uint32_t number) {
  const glm::dvec2 minimum = glm::floor(glm::min(triangle.uv[0], glm::min(triangle.uv[1], triangle.uv[2])));
  AtlasTriangle record{};
  float* const corner = &record.u0;
  for (int i = 0; i < 3; ++i) {
    corner[2 * i] = static_cast<float>(triangle.uv[i].x - minimum.x);
    corner[2 * i + 1] = static_cast<float>(triangle.uv[i].y - minimum.y);
  }
  const uint32_t pitch = chart.width == 1 ? 0 : chart.width;
  record.pitch_key = pitch | number << LUCARIUM_ATLAS_PITCH_BITS;
  record.base = first_cell + static_cast<uint32_t>(minimum.y) * pitch + static_cast<uint32_t>(minimum.x);
  return record;
}

/// Where the texels of all charts go.
class Joiner {
 public:
  Joiner(const AtlasMesh& mesh, AtlasLayout& layout, std::span<const AtlasPart> parts)
      : mesh_(mesh),
        layout_(layout),
        parts_(parts),
        first_cells_(parts.size()),
        next_single_(2 * layout.info.double_sided_count) {}

  void run() {
    for (uint32_t p = 0; p < parts_.size(); ++p) {
      first_cells_[p] = static_cast<uint32_t>(layout_.table.size());
      for (const PlacedChart& chart : parts_[p].charts)
        if (chart.absorbed_by == LUCARIUM_NONE) add(parts_[p], chart);
    }
    for (const AtlasPart& part : parts_)
      for (const PlacedChart& chart : part.charts)
        if (chart.absorbed_by != LUCARIUM_NONE) point_at_absorber(part, chart);
  }

 private:
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
    for (uint32_t i = chart.first_triangle; i < chart.first_triangle + chart.triangle_count; ++i) {
      const uint32_t t = part.triangles[i].triangle;
      layout_.triangles[t] = make_record(part.triangles[i], chart, first_cell, mesh_.number[t]);
    }
    for (uint32_t i = chart.first_texel; i < chart.first_texel + chart.texel_count; ++i)
      add_texel(part, part.texels[i], next++, chart.two_sided);
  }

  void add_texel(const AtlasPart& part, const PartTexel& texel, uint32_t side, bool two_sided) {
    const uint32_t first = static_cast<uint32_t>(layout_.pieces.size());
    add_pieces(part, texel);
    for (const TexelPlace& extra : texel.extra) add_pieces(parts_[extra.part], parts_[extra.part].texels[extra.texel]);
    const AtlasTexel record{texel.triangle, texel.b1, texel.b2, static_cast<float>(texel.area)};
    const uint2 range{first, static_cast<uint32_t>(layout_.pieces.size()) - first};
    for (const uint32_t at : {side, side + (two_sided ? layout_.info.double_sided_count : 0)}) {
      layout_.texels[at] = record;
      layout_.ranges[at] = range;
    }
  }

  void add_pieces(const AtlasPart& part, const PartTexel& texel) {
    const auto piece = part.pieces.begin() + texel.first_piece;
    layout_.pieces.insert(layout_.pieces.end(), piece, piece + texel.piece_count);
  }

  /// Constant uv in a cell of another chart.
  void point_at_absorber(const AtlasPart& part, const PlacedChart& chart) {
    for (uint32_t i = chart.first_triangle; i < chart.first_triangle + chart.triangle_count; ++i) {
      const uint32_t t = part.triangles[i].triangle;
      AtlasTriangle& record = layout_.triangles[t];
      record = make_record(part.triangles[i], chart, 0, mesh_.number[t]);
      record.base = global_cell(chart.absorbed_by, chart.absorbing_cell);
    }
  }

  /// Cells of absorbed charts are left out, so that those behind them move up.
  uint32_t global_cell(uint32_t part, uint32_t cell) {
    if (moved_part_ != part) {
      moved_part_ = part;
      moved_.clear();
      for (const PlacedChart& chart : parts_[part].charts)
        if (chart.absorbed_by != LUCARIUM_NONE) moved_.push_back(chart.first_cell);
    }
    const auto before = std::lower_bound(moved_.begin(), moved_.end(), cell) - moved_.begin();
    return first_cells_[part] + cell - static_cast<uint32_t>(before);
  }

  const AtlasMesh& mesh_;
  AtlasLayout& layout_;
  std::span<const AtlasPart> parts_;
  std::vector<uint32_t> first_cells_;
  uint32_t next_double_ = 0, next_single_;
  uint32_t moved_part_ = LUCARIUM_NONE;
  std::vector<uint32_t> moved_;
};

}  // namespace

SideCount side_count(std::span<const AtlasPart> parts, double edge) {
  SideCount sum;
  for (const AtlasPart& part : parts) {
    for (const PlacedChart& chart : part.charts) {
      if (chart.absorbed_by != LUCARIUM_NONE) continue;
      const uint64_t faces = chart.two_sided ? 2 : 1;
      sum.all += faces * chart.texel_count;
      for (uint32_t i = chart.first_texel; i < chart.first_texel + chart.texel_count; ++i)
        if (part.texels[i].area < sliver_area * edge * edge) {
          sum.slivers += faces;
          sum.sliver_area += double(faces) * part.texels[i].area;
        }
    }
  }
  return sum;
}

AtlasLayout join_parts(const AtlasMesh& mesh, std::span<const AtlasPart> parts, double edge) {
  const uint64_t sides = side_count(parts, edge).all;
  uint64_t both = 0, cells = 0, pieces = 0, charts = 0;
  for (const AtlasPart& part : parts) {
    for (const PlacedChart& chart : part.charts) {
      if (chart.absorbed_by != LUCARIUM_NONE) continue;
      if (chart.two_sided) both += chart.texel_count;
      cells += uint64_t{chart.width} * chart.height;
      ++charts;
    }
    pieces += part.pieces.size();
  }
  if (std::max({cells, pieces, sides}) >= LUCARIUM_NONE / 2) {
    throw_error(ErrorClass::usage,
                "surface atlas: {} texel sides in {} cells are more than 32-bit ids can name; ask for fewer texels",
                sides, cells);
  }
  AtlasLayout layout;
  layout.info = {static_cast<uint32_t>(sides), static_cast<uint32_t>(both), static_cast<uint32_t>(cells),
                 static_cast<float>(edge)};
  layout.triangles.resize(mesh.triangle_count());
  layout.table.reserve(cells);
  layout.links.reserve(cells);
  layout.texels.resize(layout.info.texel_count);
  layout.ranges.resize(layout.info.texel_count);
  layout.pieces.reserve(pieces);
  layout.charts.reserve(charts);
  Joiner(mesh, layout, parts).run();
  return layout;
}

void fill_empty_cells(AtlasLayout& layout) {
  std::vector<uint32_t> front, next;
  for (const AtlasChart& chart : layout.charts) {
    uint32_t* const cells = layout.table.data() + chart.first_cell;
    front.clear();
    for (uint32_t i = 0; i < chart.width * chart.height; ++i)
      if (cells[i] != LUCARIUM_NONE) front.push_back(i);
    for (; !front.empty(); front.swap(next)) {
      next.clear();
      for (const uint32_t i : front) {
        const uint32_t x = i % chart.width, y = i / chart.width;
        const auto spread = [&](bool inside, uint32_t to) {
          if (!inside || cells[to] != LUCARIUM_NONE) return;
          cells[to] = cells[i];
          next.push_back(to);
        };
        spread(x > 0, i - 1);
        spread(x + 1 < chart.width, i + 1);
        spread(y > 0, i - chart.width);
        spread(y + 1 < chart.height, i + chart.width);
      }
    }
  }
}

void place_left_out(const AtlasMesh& mesh, AtlasLayout& layout) {
  const uint32_t count = static_cast<uint32_t>(mesh.triangle_count());
  for (uint32_t t = 0; t < count; ++t)
    if (mesh.left_out[t]) layout.left_out.push_back(t);
  if (layout.left_out.empty()) return;
  std::vector<uint32_t> at_vertex(mesh.geometry.positions.size(), LUCARIUM_NONE);  // by welded vertex
  std::vector<uint32_t> in_instance(mesh.geometry.two_sided.size(), LUCARIUM_NONE);
  const auto keep_first = [](uint32_t& place, uint32_t t) { place = std::min(place, t); };
  uint32_t any = LUCARIUM_NONE;
  for (uint32_t t = 0; t < count; ++t) {
    if (mesh.left_out[t]) continue;
    keep_first(any, t);
    for (int i = 0; i < 3; ++i) keep_first(at_vertex[mesh.welded[t][i]], t);
    keep_first(in_instance[mesh.geometry.instance[t]], t);
  }
  for (const uint32_t t : layout.left_out) {
    uint32_t beside = LUCARIUM_NONE;
    for (int i = 0; i < 3; ++i) keep_first(beside, at_vertex[mesh.welded[t][i]]);
    if (beside == LUCARIUM_NONE) beside = in_instance[mesh.geometry.instance[t]];
    if (beside == LUCARIUM_NONE) beside = any;
    AtlasTriangle& record = layout.triangles[t];
    record = {0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0, 0};
    record.base = atlas_cell(layout.triangles[beside], 1.f / 3, 1.f / 3);
  }
}

}  // namespace lucarium
