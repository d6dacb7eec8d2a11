// SPDX-License-Identifier: Apache-2.0
// From the covered cells of a chart to its texels. Declared in chart.h.
#include <algorithm>
#include <numeric>

#include "lucarium/services/surface_atlas/layout/chart.h"
#include "lucarium/services/surface_atlas/layout/clip.h"

namespace lucarium {

namespace {

constexpr double max_merged = 1.5;  // area that a texel may grow to by merging [s²]
constexpr uint32_t max_across = 2;  // cells of one texel along each axis

/// The cells of a texel.
struct CellBox {
  uint32_t x0, y0, x1, y1;
  bool small() const { return x1 - x0 < max_across && y1 - y0 < max_across; }
};
CellBox joint(const CellBox& a, const CellBox& b) {
  return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

/// Whether two lists of pieces, both ascending by triangle, share a triangle; with_area: one that has area in both.
bool share_triangle(const ChartPiece* a, const ChartPiece* a_end, const ChartPiece* b, const ChartPiece* b_end,
                    bool with_area) {
  while (a != a_end && b != b_end) {
    if (a->local == b->local && (!with_area || (a->fraction > 0 && b->fraction > 0))) return true;
    if (a->local <= b->local) {
      ++a;
    } else {
      ++b;
    }
  }
  return false;
}

}  // namespace

void ChartPlacer::measure_cells() {
  const uint32_t count = static_cast<uint32_t>(covered_.size());
  cell_area_.assign(count, 0);
  index_.assign(size_t{width_} * height_, LUCARIUM_NONE);
  texel_of_.resize(count);
  std::iota(texel_of_.begin(), texel_of_.end(), 0u);
  for (uint32_t c = 0; c < count; ++c) {
    index_[covered_[c]] = c;
    for (uint32_t i = first_piece_[c]; i < first_piece_[c + 1]; ++i)
      cell_area_[c] += double(pieces_[i].fraction) * mesh_.area[chart_[pieces_[i].local].triangle];
  }
}

// Covered cell beside covered cell c, or LUCARIUM_NONE.
uint32_t ChartPlacer::neighbor_cell(uint32_t c, int dx, int dy) const {
  const int x = int(covered_[c] % width_) + dx, y = int(covered_[c] / width_) + dy;
  return x < 0 || y < 0 || x >= int(width_) || y >= int(height_) ? LUCARIUM_NONE : index_[size_t(y) * width_ + x];
}

bool ChartPlacer::cells_share_triangle(uint32_t a, uint32_t b, bool with_area) const {
  const ChartPiece* p = pieces_.data();
  return share_triangle(p + first_piece_[a], p + first_piece_[a + 1], p + first_piece_[b], p + first_piece_[b + 1],
                        with_area);
}

// Joins cells of little area, smallest first, to the largest neighbour behind a side that some triangle crosses, so
// that the pieces of the joint texel still touch. Texels stay within two cells, so that needles are not one texel from
// end to end.
void ChartPlacer::merge_small_cells() {
  const double s2 = settings_.edge * settings_.edge, threshold = settings_.merge_threshold * s2;
  std::vector<uint32_t> order;
  for (uint32_t c = 0; c < covered_.size(); ++c)
    if (cell_area_[c] > 0 && cell_area_[c] < threshold) order.push_back(c);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return cell_area_[a] < cell_area_[b]; });
  std::vector<CellBox> box;
  for (const uint32_t cell : covered_) box.push_back({cell % width_, cell / width_, cell % width_, cell / width_});
  constexpr int sides[4][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}};
  for (const uint32_t c : order) {
    const uint32_t root = find_root(texel_of_, c);
    if (cell_area_[root] >= threshold) continue;
    uint32_t best = LUCARIUM_NONE;
    for (const auto& [dx, dy] : sides) {
      const uint32_t n = neighbor_cell(c, dx, dy);
      if (n == LUCARIUM_NONE || !cells_share_triangle(c, n, true)) continue;
      const uint32_t other = find_root(texel_of_, n);
      if (other == root || cell_area_[other] + cell_area_[root] > max_merged * s2) continue;
      if (!joint(box[root], box[other]).small()) continue;
      if (best == LUCARIUM_NONE || cell_area_[other] > cell_area_[best]) best = other;
    }
    if (best == LUCARIUM_NONE) continue;
    texel_of_[root] = best;
    cell_area_[best] += cell_area_[root];
    box[best] = joint(box[root], box[best]);
  }
}

// Where a look-up that rounding brought into a cell without area belongs: the cell beside it, or LUCARIUM_NONE.
uint32_t ChartPlacer::home_of_touched(uint32_t c) {
  const int x = static_cast<int>(covered_[c] % width_), y = static_cast<int>(covered_[c] / width_);
  for (uint32_t i = first_piece_[c]; i < first_piece_[c + 1]; ++i) {
    const glm::dvec2 beside = glm::floor(point_beside_cell(chart_[pieces_[i].local].uv, x, y));
    const int dx = int(beside.x) - x, dy = int(beside.y) - y;
    if (std::abs(dx) > 1 || std::abs(dy) > 1) continue;
    const uint32_t n = neighbor_cell(c, dx, dy);
    if (n != LUCARIUM_NONE && cell_area_[find_root(texel_of_, n)] > 0) return n;
  }
  return LUCARIUM_NONE;
}

// Cells without area join the texel beside them. Where only triangles without area go on, they follow each other; what
// is left has no area anywhere near and stays alone.
void ChartPlacer::assign_touched_cells() {
  std::vector<uint32_t> open, still;
  for (uint32_t c = 0; c < covered_.size(); ++c) {
    if (cell_area_[c] > 0) continue;
    const uint32_t home = home_of_touched(c);
    if (home == LUCARIUM_NONE) {
      open.push_back(c);
    } else {
      texel_of_[c] = find_root(texel_of_, home);
    }
  }
  for (bool changed = true; changed && !open.empty(); open.swap(still)) {
    changed = false;
    still.clear();
    for (const uint32_t c : open) {
      uint32_t found = LUCARIUM_NONE;
      for (int k = 0; k < 9 && found == LUCARIUM_NONE; ++k) {
        const uint32_t n = neighbor_cell(c, k % 3 - 1, k / 3 - 1);
        if (n == LUCARIUM_NONE || n == c || !cells_share_triangle(c, n, false)) continue;
        const uint32_t other = find_root(texel_of_, n);
        if (cell_area_[other] > 0) found = other;
      }
      changed = changed || found != LUCARIUM_NONE;
      if (found == LUCARIUM_NONE) {
        still.push_back(c);
      } else {
        texel_of_[c] = found;
      }
    }
  }
  for (uint32_t c = 0; c < covered_.size(); ++c) texel_of_[c] = find_root(texel_of_, c);
}

// Appends texels with their pieces and fills the chart's cells.
void ChartPlacer::number_texels(AtlasPart& part) {
  const PlacedChart& chart = part.charts.back();
  const uint32_t count = static_cast<uint32_t>(covered_.size());
  std::vector<uint32_t> number(count, LUCARIUM_NONE), order(count);
  uint32_t texels = 0;
  for (uint32_t c = 0; c < count; ++c)
    if (texel_of_[c] == c) number[c] = texels++;
  for (uint32_t c = 0; c < count; ++c) {
    texel_of_[c] = number[texel_of_[c]];
    part.cells[chart.first_cell + covered_[c]] = chart.first_texel + texel_of_[c];
  }
  // Pieces by texel; a triangle's pieces in the same texel become one.
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return texel_of_[a] < texel_of_[b]; });
  std::vector<ChartPiece> gathered;
  for (uint32_t i = 0, next = 0; i < count; i = next) {
    gathered.clear();
    for (next = i; next < count && texel_of_[order[next]] == texel_of_[order[i]]; ++next) {
      const uint32_t c = order[next];
      gathered.insert(gathered.end(), pieces_.begin() + first_piece_[c], pieces_.begin() + first_piece_[c + 1]);
    }
    PartTexel texel{chart_[gathered[0].local].triangle, 1.f / 3, 1.f / 3, 0, uint32_t(part.pieces.size()), 0};
    double largest = -1;
    for (const ChartPiece& piece : gathered) {
      const double area = double(piece.fraction) * mesh_.area[chart_[piece.local].triangle];
      texel.area += area;
      if (area > largest) {
        largest = area;
        texel.triangle = chart_[piece.local].triangle, texel.b1 = piece.b1, texel.b2 = piece.b2;
      }
    }
    if (next - i > 1) {
      std::stable_sort(gathered.begin(), gathered.end(),
                       [](const ChartPiece& a, const ChartPiece& b) { return a.local < b.local; });
    }
    for (size_t p = 0, end = 0; p < gathered.size(); p = end) {
      float fraction = 0;
      for (end = p; end < gathered.size() && gathered[end].local == gathered[p].local; ++end)
        fraction += gathered[end].fraction;
      if (fraction > 0) part.pieces.push_back({chart_[gathered[p].local].triangle, fraction});
    }
    texel.piece_count = static_cast<uint32_t>(part.pieces.size()) - texel.first_piece;
    part.texels.push_back(texel);
  }
  part.charts.back().texel_count = texels;
}

// Which neighbours interpolation may use: those that some triangle reaches, also round a corner.
void ChartPlacer::link_cells(AtlasPart& part) const {
  const PlacedChart& chart = part.charts.back();
  uint8_t* links = part.links.data() + chart.first_cell;
  const auto set = [&](uint32_t from, int dx, int dy) {
    links[from] |= LUCARIUM_ATLAS_LINK(dx, dy);
    links[int(from) + dy * int(width_) + dx] |= LUCARIUM_ATLAS_LINK(-dx, -dy);
  };
  const auto try_link = [&](uint32_t c, int dx, int dy) {
    const uint32_t n = neighbor_cell(c, dx, dy);
    if (n != LUCARIUM_NONE && cells_share_triangle(c, n, false)) set(covered_[c], dx, dy);
  };
  for (uint32_t c = 0; c < covered_.size(); ++c) {
    try_link(c, 1, 0);
    try_link(c, 0, 1);
    try_link(c, 1, 1);
    try_link(c, -1, 1);
  }
  // Round a corner: one step and then the other.
  const auto linked = [&](uint32_t cell, int dx, int dy) { return (links[cell] & LUCARIUM_ATLAS_LINK(dx, dy)) != 0; };
  for (const uint32_t cell : covered_) {
    for (const int dx : {-1, 1}) {
      const bool along = linked(cell, dx, 0) && linked(cell + dx, 0, 1);
      const bool up = linked(cell, 0, 1) && linked(cell + width_, dx, 0);
      if (along || up) set(cell, dx, 1);
    }
  }
}

}  // namespace lucarium
