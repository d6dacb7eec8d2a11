// SPDX-License-Identifier: Apache-2.0
// Charts of a fraction of a texel join a texel of the chart beside them. Declared in table.h.
#include <cmath>

#include "lucarium/services/surface_atlas/layout/table.h"

namespace lucarium {

namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double max_absorbed = 1.5;  // area that a texel may grow to [s²]
constexpr double max_reach = 2;       // from a texel's sample position to what it absorbs [s]
constexpr double normal_degrees = 75;

class Absorber {
 public:
  Absorber(const AtlasMesh& mesh, const ChartSettings& settings, std::vector<AtlasPart>& parts)
      : mesh_(mesh), settings_(settings), parts_(parts), places_(mesh.triangle_count()) {
    for (uint32_t p = 0; p < parts.size(); ++p) {
      for (uint32_t c = 0; c < parts[p].charts.size(); ++c) {
        const PlacedChart& chart = parts[p].charts[c];
        for (uint32_t i = chart.first_triangle; i < chart.first_triangle + chart.triangle_count; ++i)
          places_[parts[p].triangles[i].triangle] = {p, c, i};
      }
    }
  }

  void run() {
    const double s2 = settings_.edge * settings_.edge;
    for (uint32_t p = 0; p < parts_.size(); ++p) {
      for (PlacedChart& chart : parts_[p].charts) {
        const PartTexel& texel = parts_[p].texels[chart.first_texel];
        if (chart.width == 1 && texel.area < settings_.merge_threshold * s2 && texel.extra.empty()) absorb(p, chart);
      }
    }
  }

 private:
  struct Place {
    uint32_t part, chart, index;
  };

  /// Cell of a triangle's chart (in its part) where the middle of one of its edges lies.
  uint32_t cell_at(uint32_t triangle, int edge) const {
    const Place& place = places_[triangle];
    const PlacedChart& chart = parts_[place.part].charts[place.chart];
    if (chart.width == 1) return chart.first_cell;
    const dvec2* uv = parts_[place.part].triangles[place.index].uv;
    const dvec2 at = glm::floor(0.5 * (uv[edge] + uv[(edge + 1) % 3]));
    return chart.first_cell + static_cast<uint32_t>(at.y) * chart.width + static_cast<uint32_t>(at.x);
  }

  bool within_reach(const PartTexel& texel, uint32_t part, const PlacedChart& chart) const {
    const dvec3 a = mesh_.position(texel.triangle, 0);
    const dvec3 sample = a + double(texel.b1) * (mesh_.position(texel.triangle, 1) - a) +
                         double(texel.b2) * (mesh_.position(texel.triangle, 2) - a);
    for (uint32_t i = chart.first_triangle; i < chart.first_triangle + chart.triangle_count; ++i) {
      for (int k = 0; k < 3; ++k) {
        const dvec3 away = mesh_.position(parts_[part].triangles[i].triangle, k) - sample;
        if (!(glm::length(away) <= max_reach * settings_.edge)) return false;
      }
    }
    return true;
  }

  void absorb(uint32_t part, PlacedChart& chart) {
    static const double min_cosine = cos_degrees(normal_degrees);
    const double area = parts_[part].texels[chart.first_texel].area;
    double longest = 0;
    uint32_t best_part = 0, best_cell = LUCARIUM_NONE;
    for (uint32_t i = chart.first_triangle; i < chart.first_triangle + chart.triangle_count; ++i) {
      const uint32_t triangle = parts_[part].triangles[i].triangle;
      for (int edge = 0; edge < 3; ++edge) {
        const uint32_t other = mesh_.neighbor[triangle][edge];
        if (other == LUCARIUM_NONE) continue;
        const Place& place = places_[other];
        const PlacedChart& beside = parts_[place.part].charts[place.chart];
        if (&beside == &chart || beside.absorbed_by != LUCARIUM_NONE) continue;
        const double length = glm::length(mesh_.position(triangle, (edge + 1) % 3) - mesh_.position(triangle, edge));
        const double cosine = double(glm::dot(mesh_.normal[triangle], mesh_.normal[other]));
        if (length <= longest || (cosine < min_cosine && mesh_.normal[triangle] != glm::vec3(0))) continue;
        const uint32_t cell = cell_at(other, mesh_.edge_to(other, triangle));
        if (parts_[place.part].cells[cell] == LUCARIUM_NONE) continue;
        const PartTexel& texel = parts_[place.part].texels[parts_[place.part].cells[cell]];
        if (texel.area + area > max_absorbed * settings_.edge * settings_.edge) continue;
        if (!within_reach(texel, part, chart)) continue;
        longest = length, best_part = place.part, best_cell = cell;
      }
    }
    if (best_cell == LUCARIUM_NONE) return;
    PartTexel& texel = parts_[best_part].texels[parts_[best_part].cells[best_cell]];
    texel.area += area;
    texel.extra.push_back({part, chart.first_texel});
    chart.absorbed_by = best_part;
    chart.absorbing_cell = best_cell;
  }

  const AtlasMesh& mesh_;
  const ChartSettings& settings_;
  std::vector<AtlasPart>& parts_;
  std::vector<Place> places_;
};

}  // namespace

void absorb_fragments(const AtlasMesh& mesh, const ChartSettings& settings, std::vector<AtlasPart>& parts) {
  if (settings.merge_threshold > 0) Absorber(mesh, settings, parts).run();
}

}  // namespace lucarium
