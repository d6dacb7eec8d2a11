// SPDX-License-Identifier: Apache-2.0
// A chart's triangles cut into cells; triangles that a cell would join with others that they do not touch there leave.
// Declared in chart.h.
#include <algorithm>
#include <numeric>

#include "lucarium/services/surface_atlas/layout/chart.h"
#include "lucarium/services/surface_atlas/layout/clip.h"

namespace lucarium {

// Fills pieces_, sorted by cell and triangle, with a counting sort over cells.
void ChartPlacer::cut_into_cells() {
  std::vector<ClippedCell> cells;
  std::vector<uint32_t> first(size_t{width_} * height_ + 1, 0);
  std::vector<ChartPiece> unsorted;
  for (uint32_t i = 0; i < chart_.size(); ++i) {
    cells.clear();
    clip_to_cells(chart_[i].uv, cells);
    for (const ClippedCell& cell : cells) {
      const uint32_t x = std::clamp(cell.x, 0, int(width_) - 1), y = std::clamp(cell.y, 0, int(height_) - 1);
      unsorted.push_back({y * width_ + x, i, cell.fraction, cell.b1, cell.b2});
      ++first[unsorted.back().cell + 1];
    }
  }
  std::partial_sum(first.begin(), first.end(), first.begin());
  pieces_.resize(unsorted.size());
  for (const ChartPiece& piece : unsorted) pieces_[first[piece.cell]++] = piece;
}

void ChartPlacer::index_cells() {
  covered_.clear();
  first_piece_.clear();
  for (uint32_t i = 0; i < pieces_.size(); ++i) {
    if (i > 0 && pieces_[i].cell == pieces_[i - 1].cell) continue;
    covered_.push_back(pieces_[i].cell);
    first_piece_.push_back(i);
  }
  first_piece_.push_back(static_cast<uint32_t>(pieces_.size()));
}

// Joins pieces of one cell (alive: indices into pieces_) whose triangles share an edge that crosses the dilated cell,
// or a vertex inside it: then they touch there. Leaves the components in parent_ (indices into `alive`), returns
// their number.
uint32_t ChartPlacer::connect_pieces(const std::vector<uint32_t>& alive) {
  const uint32_t count = static_cast<uint32_t>(alive.size());
  parent_.resize(count);
  std::iota(parent_.begin(), parent_.end(), 0u);
  uint32_t components = count;
  const auto join = [&](uint32_t a, uint32_t b) {
    a = find_root(parent_, a), b = find_root(parent_, b);
    if (a == b) return;
    parent_[std::max(a, b)] = std::min(a, b);
    --components;
  };
  const int x = static_cast<int>(pieces_[alive[0]].cell % width_),
            y = static_cast<int>(pieces_[alive[0]].cell / width_);
  keys_.clear();
  for (uint32_t i = 0; i < count; ++i) {
    const ChartTriangle& t = chart_[pieces_[alive[i]].local];
    const double dilation = cell_dilation(t.uv);
    const glm::uvec3& corners = mesh_.welded[t.triangle];
    for (int k = 0; k < 3; ++k) {
      const uint64_t a = corners[k], b = corners[(k + 1) % 3];
      if (segment_touches_cell(t.uv[k], t.uv[k], x, y, dilation)) keys_.emplace_back(a << 32 | a, i);
      if (a != b && segment_touches_cell(t.uv[k], t.uv[(k + 1) % 3], x, y, dilation))
        keys_.emplace_back(std::min(a, b) << 32 | std::max(a, b), i);
    }
  }
  std::sort(keys_.begin(), keys_.end());
  for (size_t i = 1; i < keys_.size(); ++i)
    if (keys_[i].first == keys_[i - 1].first) join(keys_[i].second, keys_[i - 1].second);
  for (uint32_t i = 0; i < count; ++i) parent_[i] = find_root(parent_, i);
  return components;
}

// Where the pieces of a cell do not hang together, keeps the component of the largest triangles and marks the others.
// The chart's largest triangle always stays, so that every chart that leaves is smaller than this one.
bool ChartPlacer::split_cell(uint32_t first, uint32_t last, std::vector<uint8_t>& is_ejected, uint32_t keep) {
  alive_.clear();
  for (uint32_t i = first; i < last; ++i)
    if (!is_ejected[pieces_[i].local]) alive_.push_back(i);
  if (alive_.size() < 2 || connect_pieces(alive_) == 1) return false;
  std::vector<double> area(alive_.size(), 0);
  for (uint32_t i = 0; i < alive_.size(); ++i) {
    const uint32_t local = pieces_[alive_[i]].local;
    area[parent_[i]] += local == keep ? 1e300 : mesh_.area[chart_[local].triangle];
  }
  const uint32_t winner = static_cast<uint32_t>(std::max_element(area.begin(), area.end()) - area.begin());
  for (uint32_t i = 0; i < alive_.size(); ++i)
    if (parent_[i] != winner) is_ejected[pieces_[alive_[i]].local] = 1;
  return true;
}

// Ejects triangles until the pieces of every cell touch each other inside it. A triangle that leaves may have been what
// joined others, hence the repetition.
void ChartPlacer::eject(std::vector<uint32_t>& ejected) {
  std::vector<uint8_t> is_ejected(chart_.size(), 0);
  uint32_t keep = 0;
  for (uint32_t i = 1; i < chart_.size(); ++i)
    if (mesh_.area[chart_[i].triangle] > mesh_.area[chart_[keep].triangle]) keep = i;
  bool changed = true, any = false;
  while (changed) {
    changed = false;
    for (size_t c = 0; c < covered_.size(); ++c) {
      if (first_piece_[c + 1] - first_piece_[c] < 2) continue;
      changed = split_cell(first_piece_[c], first_piece_[c + 1], is_ejected, keep) || changed;
    }
    any = any || changed;
  }
  if (!any) return;
  std::vector<uint32_t> new_local(chart_.size());
  uint32_t kept = 0;
  for (uint32_t i = 0; i < chart_.size(); ++i) {
    if (is_ejected[i]) {
      ejected.push_back(chart_[i].triangle);
    } else {
      new_local[i] = kept;
      chart_[kept++] = chart_[i];
    }
  }
  chart_.resize(kept);
  std::erase_if(pieces_, [&](const ChartPiece& piece) { return is_ejected[piece.local]; });
  for (ChartPiece& piece : pieces_) piece.local = new_local[piece.local];
  index_cells();
}

}  // namespace lucarium
