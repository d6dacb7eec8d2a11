// SPDX-License-Identifier: Apache-2.0
// Interpolation across smooth seams: empty cells along a chart's border get the texels of the chart behind it. Declared
// in table.h.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "lucarium/services/surface_atlas/layout/clip.h"
#include "lucarium/services/surface_atlas/layout/table.h"

namespace lucarium {

namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double smooth_degrees = 60;     // dihedral angle up to which light is taken to go on across a seam
constexpr double crossing_margin = 1e-3;  // of cells that a border edge crosses [cells]

/// The nearest border edge to the centre of an empty cell.
struct Candidate {
  uint32_t cell;  ///< y · width + x of the chart
  double distance;
  uint32_t triangle;
  int edge;
};

class SeamLinker {
 public:
  SeamLinker(const AtlasMesh& mesh, std::span<const AtlasPart> parts, AtlasLayout& layout)
      : mesh_(mesh),
        layout_(layout),
        chart_of_(mesh.triangle_count(), LUCARIUM_NONE),
        placed_(mesh.triangle_count(), nullptr) {
    uint32_t chart = 0;
    for (const AtlasPart& part : parts) {
      for (const PlacedChart& placed : part.charts) {
        if (placed.absorbed_by != LUCARIUM_NONE) continue;
        for (uint32_t i = placed.first_triangle; i < placed.first_triangle + placed.triangle_count; ++i) {
          chart_of_[part.triangles[i].triangle] = chart;
          placed_[part.triangles[i].triangle] = &part.triangles[i];
        }
        ++chart;
      }
    }
  }

  void run(std::span<const AtlasPart> parts) {
    uint32_t chart = 0;
    for (const AtlasPart& part : parts) {
      for (const PlacedChart& placed : part.charts) {
        if (placed.absorbed_by != LUCARIUM_NONE) continue;
        if (placed.width > 1) link_chart(part, placed, layout_.charts[chart]);
        ++chart;
      }
    }
    for (const auto& [cell, texel] : filled_) layout_.table[cell] = texel;
  }

 private:
  bool is_smooth_seam(uint32_t triangle, int edge) const {
    static const double smooth = cos_degrees(smooth_degrees);
    const uint32_t other = mesh_.neighbor[triangle][edge];
    return other != LUCARIUM_NONE && chart_of_[other] != chart_of_[triangle] &&
           double(glm::dot(mesh_.normal[triangle], mesh_.normal[other])) > smooth;
  }
  void link_chart(const AtlasPart& part, const PlacedChart& placed, const AtlasChart& chart);
  void offer_cells(const AtlasChart& chart, uint32_t triangle, int edge);
  uint32_t texel_behind(uint32_t triangle, int edge, const dvec2& at) const;
  uint32_t texel_at(uint32_t triangle, const dvec2& barycentrics) const;

  const AtlasMesh& mesh_;
  AtlasLayout& layout_;
  std::vector<uint32_t> chart_of_;  ///< LUCARIUM_NONE for absorbed charts, which have no cells
  std::vector<const ChartTriangle*> placed_;
  std::vector<Candidate> candidates_;
  std::vector<std::pair<uint32_t, uint32_t>> filled_;  ///< cell, texel; written last, so that order does not matter
};

dvec2 cell_center(uint32_t cell, uint32_t width) {
  const uint32_t x = cell % width, y = cell / width;
  return {x + 0.5, y + 0.5};
}

// Empty cells around an edge whose centres lie outside the chart.
void SeamLinker::offer_cells(const AtlasChart& chart, uint32_t triangle, int edge) {
  const ChartTriangle& t = *placed_[triangle];
  const dvec2 a = t.uv[edge], b = t.uv[(edge + 1) % 3], along = b - a;
  const double length2 = glm::dot(along, along);
  if (!(length2 > 0)) return;
  const auto range = [](double low, double high, uint32_t size, int& first, int& last) {
    first = std::max(0, static_cast<int>(std::floor(low)) - 1);
    last = std::min(static_cast<int>(size) - 1, static_cast<int>(std::floor(high)) + 1);
  };
  int y0, y1;
  range(std::min(a.y, b.y), std::max(a.y, b.y), chart.height, y0, y1);
  for (int y = y0; y <= y1; ++y) {
    // Only the columns near the edge within this row.
    double from = 0, to = 1;
    if (along.y != 0) {
      from = std::clamp((y - 1 - a.y) / along.y, 0., 1.);
      to = std::clamp((y + 2 - a.y) / along.y, 0., 1.);
    }
    const double xa = a.x + from * along.x, xb = a.x + to * along.x;
    int x0, x1;
    range(std::min(xa, xb), std::max(xa, xb), chart.width, x0, x1);
    for (int x = x0; x <= x1; ++x) {
      const uint32_t cell = static_cast<uint32_t>(y) * chart.width + static_cast<uint32_t>(x);
      if (layout_.table[chart.first_cell + cell] != LUCARIUM_NONE) continue;
      const dvec2 center(x + 0.5, y + 0.5);
      const double at = std::clamp(glm::dot(center - a, along) / length2, 0., 1.);
      const double distance = glm::length(center - a - at * along);
      if (distance < 1.5) candidates_.push_back({cell, distance, triangle, edge});
    }
  }
}

// The texel of a triangle's chart at barycentrics that may lie outside the triangle, or LUCARIUM_NONE.
uint32_t SeamLinker::texel_at(uint32_t triangle, const dvec2& barycentrics) const {
  const AtlasTriangle& record = layout_.triangles[triangle];
  if (LUCARIUM_ATLAS_PITCH(record) == 0) return layout_.table[record.base];
  const AtlasChart& chart = layout_.charts[chart_of_[triangle]];
  const dvec2* uv = placed_[triangle]->uv;
  const dvec2 at = glm::floor(uv[0] + barycentrics.x * (uv[1] - uv[0]) + barycentrics.y * (uv[2] - uv[0]));
  if (at.x < 0 || at.y < 0 || at.x >= chart.width || at.y >= chart.height) return LUCARIUM_NONE;
  return layout_.table[chart.first_cell + static_cast<uint32_t>(at.y) * chart.width + static_cast<uint32_t>(at.x)];
}

// The texel that lies where a cell outside the chart would be if the surface behind the edge were unfolded.
uint32_t SeamLinker::texel_behind(uint32_t triangle, int edge, const dvec2& at) const {
  const uint32_t other = mesh_.neighbor[triangle][edge];
  const dvec2* uv = placed_[triangle]->uv;
  const dvec2 along = uv[(edge + 1) % 3] - uv[edge];
  const double position = std::clamp(glm::dot(at - uv[edge], along) / glm::dot(along, along), 0., 1.);
  const double distance = glm::length(at - uv[edge] - position * along) * double(layout_.info.texel_edge);
  const dvec3 a = mesh_.position(triangle, edge), b = mesh_.position(triangle, (edge + 1) % 3);
  const dvec3 on_edge = a + position * (b - a);
  const dvec3 corner = mesh_.position(other, 0), e1 = mesh_.position(other, 1) - corner,
              e2 = mesh_.position(other, 2) - corner;
  const dvec3 away = glm::cross(dvec3(mesh_.normal[other]), a - b);
  const auto barycentrics = [&](const dvec3& p) {
    const dvec3 d = p - corner, n = glm::cross(e1, e2);
    const double n2 = glm::dot(n, n);
    return dvec2(glm::dot(glm::cross(d, e2), n), glm::dot(glm::cross(e1, d), n)) / n2;
  };
  const uint32_t unfolded = texel_at(other, barycentrics(on_edge + distance / glm::length(away) * away));
  if (unfolded != LUCARIUM_NONE) return unfolded;
  const dvec2 edge_point = barycentrics(on_edge);
  return texel_at(other, edge_point + 1e-3 * (dvec2(1. / 3) - edge_point));
}

void SeamLinker::link_chart(const AtlasPart& part, const PlacedChart& placed, const AtlasChart& chart) {
  candidates_.clear();
  for (uint32_t i = placed.first_triangle; i < placed.first_triangle + placed.triangle_count; ++i) {
    const uint32_t triangle = part.triangles[i].triangle;
    for (int edge = 0; edge < 3; ++edge)
      if (is_smooth_seam(triangle, edge)) offer_cells(chart, triangle, edge);
  }
  std::sort(candidates_.begin(), candidates_.end(), [](const Candidate& a, const Candidate& b) {
    return std::tie(a.cell, a.distance, a.triangle, a.edge) < std::tie(b.cell, b.distance, b.triangle, b.edge);
  });
  uint8_t* links = layout_.links.data() + chart.first_cell;
  for (size_t i = 0; i < candidates_.size(); ++i) {
    if (i > 0 && candidates_[i].cell == candidates_[i - 1].cell) continue;
    const auto& [cell, distance, triangle, edge] = candidates_[i];
    const uint32_t texel = texel_behind(triangle, edge, cell_center(cell, chart.width));
    if (texel == LUCARIUM_NONE) continue;
    filled_.emplace_back(chart.first_cell + cell, texel);
    // Cells of the chart that the edge crosses may interpolate into this one.
    const dvec2* uv = placed_[triangle]->uv;
    const int x = static_cast<int>(cell % chart.width), y = static_cast<int>(cell / chart.width);
    for (int k = 0; k < 9; ++k) {
      const int dx = k % 3 - 1, dy = k / 3 - 1;
      if (k == 4 || x + dx < 0 || y + dy < 0 || x + dx >= int(chart.width) || y + dy >= int(chart.height)) continue;
      if (segment_touches_cell(uv[edge], uv[(edge + 1) % 3], x + dx, y + dy, crossing_margin))
        links[(y + dy) * int(chart.width) + x + dx] |= LUCARIUM_ATLAS_LINK(-dx, -dy);
    }
  }
}

}  // namespace

void link_seams(const AtlasMesh& mesh, std::span<const AtlasPart> parts, AtlasLayout& layout) {
  SeamLinker linker(mesh, parts, layout);
  linker.run(parts);
}

}  // namespace lucarium
