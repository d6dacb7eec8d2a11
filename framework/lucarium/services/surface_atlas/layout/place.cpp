// SPDX-License-Identifier: Apache-2.0
// Places the texels of charts. Declared in chart.h.
#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/services/surface_atlas/layout/chart.h"

namespace lucarium {

namespace {

constexpr double max_cells = 2e9;  // of one chart; cells have 32-bit numbers
constexpr uint32_t max_width = (1u << LUCARIUM_ATLAS_PITCH_BITS) - 1;

}  // namespace

ChartPlacer::ChartPlacer(const AtlasMesh& mesh, const ChartSettings& settings)
    : mesh_(mesh), settings_(settings), place_(mesh.triangle_count(), LUCARIUM_NONE) {}

// At most s² in area and 2 s across: not worth a grid. Neither is what has no area at all.
bool ChartPlacer::is_one_texel(const std::vector<uint32_t>& triangles) const {
  double area = 0;
  glm::dvec3 low(INFINITY), high(-INFINITY);
  for (const uint32_t t : triangles) {
    area += mesh_.area[t];
    for (int i = 0; i < 3; ++i) low = glm::min(low, mesh_.position(t, i)), high = glm::max(high, mesh_.position(t, i));
  }
  const double s = settings_.edge;
  return !(area > 0) || (area <= s * s && glm::length(high - low) <= 2 * s);
}

void ChartPlacer::place_one_texel(const std::vector<uint32_t>& triangles, AtlasPart& part) const {
  part.charts.push_back({uint32_t(part.triangles.size()), uint32_t(triangles.size()), uint32_t(part.cells.size()), 1, 1,
                         uint32_t(part.texels.size()), 1, mesh_.two_sided(triangles[0])});
  PartTexel texel{triangles[0], 1.f / 3, 1.f / 3, 0, uint32_t(part.pieces.size()), uint32_t(triangles.size())};
  for (const uint32_t t : triangles) {
    const glm::dvec2 middle(0.5);
    part.triangles.push_back({t, {middle, middle, middle}});
    part.pieces.push_back({t, 1.f});
    texel.area += mesh_.area[t];
    if (mesh_.area[t] > mesh_.area[texel.triangle]) texel.triangle = t;
  }
  part.cells.push_back(static_cast<uint32_t>(part.texels.size()));
  part.links.push_back(0);
  part.texels.push_back(texel);
}

// chart_ on its grid, without what had to leave.
void ChartPlacer::place_grid(AtlasPart& part) {
  if (double(width_) * double(height_) > max_cells || width_ > max_width) {
    throw_error(ErrorClass::usage, "surface atlas: a chart of {}x{} texels is too large; ask for fewer texels", width_,
                height_);
  }
  cut_into_cells();
  index_cells();
  std::vector<uint32_t> ejected;
  eject(ejected);
  if (!ejected.empty()) queue_parts(ejected);
  part.charts.push_back({uint32_t(part.triangles.size()), uint32_t(chart_.size()), uint32_t(part.cells.size()), width_,
                         height_, uint32_t(part.texels.size()), 0, mesh_.two_sided(chart_[0].triangle)});
  part.triangles.insert(part.triangles.end(), chart_.begin(), chart_.end());
  part.cells.resize(part.cells.size() + size_t{width_} * height_, LUCARIUM_NONE);
  part.links.resize(part.cells.size(), 0);
  measure_cells();
  merge_small_cells();
  assign_touched_cells();
  number_texels(part);
  link_cells(part);
}

// Connected parts of a set are charts of their own.
void ChartPlacer::queue_parts(const std::vector<uint32_t>& triangles) {
  for (uint32_t i = 0; i < triangles.size(); ++i) place_[triangles[i]] = i;
  std::vector<uint32_t> part;
  const uint32_t count = number_parts(
      mesh_, triangles, [&](uint32_t t) { return place_[t]; }, part);
  for (const uint32_t t : triangles) place_[t] = LUCARIUM_NONE;
  const size_t first = queue_.size();
  queue_.resize(first + count);
  for (uint32_t i = 0; i < triangles.size(); ++i) queue_[first + part[i]].push_back(triangles[i]);
}

void ChartPlacer::place(const std::vector<uint32_t>& triangles, bool one_texel, AtlasPart& part) {
  if (one_texel) return place_one_texel(triangles, part);
  queue_.push_back(triangles);
  while (!queue_.empty()) {
    const std::vector<uint32_t> current = std::move(queue_.back());
    queue_.pop_back();
    if (is_one_texel(current) || !project(current)) {
      place_one_texel(current, part);
      continue;
    }
    std::vector<uint32_t> one, other;
    if (bisect(one, other)) {
      queue_parts(one);
      queue_parts(other);
      continue;
    }
    fit_grid();
    place_grid(part);
  }
}

}  // namespace lucarium
