// SPDX-License-Identifier: Apache-2.0
// Random points of texels. Declared in table.h.
#include <algorithm>
#include <cmath>

#include "lucarium/services/surface_atlas/layout/clip.h"
#include "lucarium/services/surface_atlas/layout/table.h"

namespace lucarium {

namespace {

/// Steele, Lea, Flood: Fast splittable pseudorandom number generators, OOPSLA 2014.
uint64_t splitmix(uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}
double unit(uint64_t x) { return double(x >> 11) * 0x1p-53; }
double fraction(double x) { return x - std::floor(x); }

/// Goes over all parts of triangles in texels, one after the other. Each point of a texel is the place of one of its
/// parts, chosen by area (a reservoir, so that parts need not be known together); within its part it is a point of the
/// additive sequence of the plastic number, so that the points of a texel of one part are evenly spread.
class Sampler {
 public:
  Sampler(const AtlasMesh& mesh, AtlasLayout& layout, uint32_t count)
      : mesh_(mesh), layout_(layout), count_(count), area_(layout.info.texel_count, 0) {
    layout_.samples.reserve(size_t{layout.info.texel_count} * count);
    for (const AtlasTexel& texel : layout_.texels)
      layout_.samples.insert(layout_.samples.end(), count, {texel.triangle, texel.b1, texel.b2});
  }

  void run() {
    std::vector<ClippedCell> cells;
    for (uint32_t t = 0; t < layout_.triangles.size(); ++t) {
      const AtlasTriangle& record = layout_.triangles[t];
      const glm::dvec2 uv[3] = {{record.u0, record.v0}, {record.u1, record.v1}, {record.u2, record.v2}};
      if (LUCARIUM_ATLAS_PITCH(record) == 0) {
        add(t, uv, {0, 0, 1.f, 1.f / 3, 1.f / 3}, layout_.table[record.base]);
        continue;
      }
      cells.clear();
      clip_to_cells(uv, cells);
      for (const ClippedCell& cell : cells)
        if (cell.fraction > 0)
          add(t, uv, cell,
              layout_.table[record.base + uint32_t(cell.y) * LUCARIUM_ATLAS_PITCH(record) + uint32_t(cell.x)]);
    }
    const uint32_t both = layout_.info.double_sided_count;
    const auto first = layout_.samples.begin();
    std::copy(first, first + size_t{both} * count_, first + size_t{both} * count_);
  }

 private:
  void add(uint32_t triangle, const glm::dvec2 uv[3], const ClippedCell& cell, uint32_t texel) {
    const double area = double(cell.fraction) * mesh_.area[triangle];
    if (!(area > 0)) return;
    area_[texel] += area;
    const uint64_t place = uint64_t(uint32_t(cell.y)) << 32 | uint32_t(cell.x);
    for (uint32_t k = 0; k < count_; ++k) {
      const uint64_t own = splitmix(uint64_t{texel} * count_ + k);
      if (unit(splitmix(own ^ splitmix(place ^ splitmix(mesh_.number[triangle])))) * area_[texel] >= area) continue;
      const uint64_t shift = splitmix(~uint64_t{texel});
      const glm::dvec2 u(fraction(unit(shift) + 0.7548776662466927 * k),
                         fraction(unit(splitmix(shift)) + 0.5698402909980532 * k));
      AtlasSample& sample = layout_.samples[size_t{texel} * count_ + k];
      sample = {triangle, cell.b1, cell.b2};
      static constexpr glm::dvec2 whole[3] = {{0, 0}, {1, 0}, {0, 1}};
      const bool all = cell.fraction == 1.f;  // of charts of one texel uv are constant
      sample_in_cell(all ? whole : uv, all ? 0 : cell.x, all ? 0 : cell.y, u, sample.b1, sample.b2);
    }
  }

  const AtlasMesh& mesh_;
  AtlasLayout& layout_;
  uint32_t count_;
  std::vector<double> area_;  ///< of what has been seen of each texel
};

}  // namespace

void sample_texels(const AtlasMesh& mesh, AtlasLayout& layout, uint32_t count) {
  if (count > 0) Sampler(mesh, layout, count).run();
}

}  // namespace lucarium
