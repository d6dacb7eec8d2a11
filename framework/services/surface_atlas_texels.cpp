// SPDX-License-Identifier: Apache-2.0
// From the covered cells of a chart to its texels.
#include <algorithm>
#include <numeric>

#include "lucarium/services/surface_atlas_chart.h"

namespace lucarium {

namespace {

constexpr double most_merged = 1.5;  // area that a texel may grow to by merging [s²]

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

// Joins cells of little area to a neighbour that some triangle reaches from them, so that the pieces of the joint texel
// still touch. Cells without area follow a neighbour in any case. Leaves representatives in texel_of_.
void ChartPlacer::merge_texels() {
  const uint32_t count = static_cast<uint32_t>(covered_.size());
  std::vector<double> area(count, 0);
  for (uint32_t c = 0; c < count; ++c) {
    for (uint32_t i = first_piece_[c]; i < first_piece_[c + 1]; ++i)
      area[c] += double(pieces_[i].fraction) * mesh_.area[chart_[pieces_[i].local].triangle];
  }
  texel_of_.resize(count);
  std::iota(texel_of_.begin(), texel_of_.end(), 0u);
  std::vector<uint32_t> index(size_t{width_} * height_, LUCARIUM_NONE);
  for (uint32_t c = 0; c < count; ++c) index[covered_[c]] = c;
  const auto neighbor = [&](uint32_t c, int dx, int dy) {
    const int x = int(covered_[c] % width_) + dx, y = int(covered_[c] / width_) + dy;
    return x < 0 || y < 0 || x >= int(width_) || y >= int(height_) ? LUCARIUM_NONE : index[y * width_ + x];
  };
  const auto touch = [&](uint32_t a, uint32_t b, bool with_area) {
    const ChartPiece* p = pieces_.data();
    return share_triangle(p + first_piece_[a], p + first_piece_[a + 1], p + first_piece_[b], p + first_piece_[b + 1],
                          with_area);
  };
  const auto absorb = [&](uint32_t root, uint32_t into) {
    texel_of_[root] = into;
    area[into] += area[root];
  };

  // Smallest first; each joins the largest neighbour that does not become too large.
  const double threshold = settings_.merge_threshold * settings_.edge * settings_.edge;
  const double largest = most_merged * settings_.edge * settings_.edge;
  std::vector<uint32_t> order;
  for (uint32_t c = 0; c < count; ++c)
    if (area[c] > 0 && area[c] < threshold) order.push_back(c);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return area[a] < area[b]; });
  constexpr int around[8][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
  for (const uint32_t c : order) {
    const uint32_t root = find_root(texel_of_, c);
    if (area[root] >= threshold) continue;
    uint32_t best = LUCARIUM_NONE;
    for (int k = 0; k < 4; ++k) {
      const uint32_t n = neighbor(c, around[k][0], around[k][1]);
      if (n == LUCARIUM_NONE || !touch(c, n, true)) continue;
      const uint32_t other = find_root(texel_of_, n);
      if (other == root || area[other] + area[root] > largest) continue;
      if (best == LUCARIUM_NONE || area[other] > area[best]) best = other;
    }
    if (best != LUCARIUM_NONE) absorb(root, best);
  }

  // Cells that are only touched, spreading from those with area.
  std::vector<uint32_t> empty;
  for (uint32_t c = 0; c < count; ++c)
    if (area[c] == 0 && texel_of_[c] == c) empty.push_back(c);
  for (bool changed = true; changed && !empty.empty();) {
    changed = false;
    std::vector<uint32_t> still;
    for (const uint32_t c : empty) {
      uint32_t best = LUCARIUM_NONE;
      for (const auto& [dx, dy] : around) {
        const uint32_t n = neighbor(c, dx, dy);
        if (n == LUCARIUM_NONE || !touch(c, n, false)) continue;
        const uint32_t other = find_root(texel_of_, n);
        if (area[other] > 0 && (best == LUCARIUM_NONE || area[other] > area[best])) best = other;
      }
      if (best == LUCARIUM_NONE) {
        still.push_back(c);
      } else {
        texel_of_[c] = best;
        changed = true;
      }
    }
    empty = std::move(still);
  }
  for (uint32_t c = 0; c < count; ++c) texel_of_[c] = find_root(texel_of_, c);
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
  std::vector<uint32_t> index(size_t{width_} * height_, LUCARIUM_NONE);
  for (uint32_t c = 0; c < covered_.size(); ++c) index[covered_[c]] = c;
  const auto set = [&](uint32_t from, int dx, int dy) {
    links[from] |= LUCARIUM_ATLAS_LINK(dx, dy);
    links[from + dy * int(width_) + dx] |= LUCARIUM_ATLAS_LINK(-dx, -dy);
  };
  const auto try_link = [&](uint32_t c, int dx, int dy) {
    const uint32_t cell = covered_[c];
    const int x = int(cell % width_) + dx, y = int(cell / width_) + dy;
    if (x < 0 || y < 0 || x >= int(width_) || y >= int(height_)) return;
    const uint32_t n = index[y * width_ + x];
    if (n == LUCARIUM_NONE) return;
    const ChartPiece* p = pieces_.data();
    if (share_triangle(p + first_piece_[c], p + first_piece_[c + 1], p + first_piece_[n], p + first_piece_[n + 1], false))
      set(cell, dx, dy);
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
