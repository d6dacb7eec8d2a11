// SPDX-License-Identifier: Apache-2.0
// Random points of texels: each lies in its texel, and they fill it evenly.
#include <map>

#include "lucarium/scene/builtin/scenes.h"
#include "support.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

AtlasLayout lay_out_samples(const AtlasGeometry& g, uint64_t texels, uint32_t samples) {
  AtlasLayoutOptions options;
  options.texel_count = texels;
  options.samples = samples;
  return make_atlas_layout(g, options);
}

}  // namespace

TEST_CASE("points of texels look up their texel") {
  for (const char* name : {"cornell", "furnace", "atrium"}) {
    const std::string scene = name;
    CAPTURE(scene);
    const AtlasGeometry g = geometry_of(make_builtin_scene(name));
    const uint32_t count = 4;
    const AtlasLayout layout = lay_out_samples(g, 5000, count);
    REQUIRE(layout.samples.size() == size_t{layout.info.texel_count} * count);
    const uint32_t both = layout.info.double_sided_count;
    size_t elsewhere = 0;
    for (uint32_t side = 0; side < layout.info.texel_count; ++side) {
      const uint32_t texel = side >= both && side < 2 * both ? side - both : side;
      for (uint32_t k = 0; k < count; ++k) {
        const AtlasSample& s = layout.samples[size_t{side} * count + k];
        REQUIRE(s.triangle < g.triangles.size());
        CHECK((s.b1 >= 0 && s.b2 >= 0 && s.b1 + s.b2 <= 1.000001f));
        elsewhere += layout.table[atlas_cell(layout.triangles[s.triangle], s.b1, s.b2)] != texel;
      }
    }
    CHECK(elsewhere * 10000 <= layout.samples.size());  // points on the borders of cells round into the next one
  }
}

TEST_CASE("points of texels are where their area is") {
  // Means over a texel of x, y, z and their squares: of points, and by integrating over every triangle on a fine grid.
  const AtlasGeometry g = geometry_of(make_builtin_scene("furnace"));
  const uint32_t count = 256;
  const AtlasLayout layout = lay_out_samples(g, 300, count);
  struct Moments {
    double area = 0;
    glm::dvec3 first{0}, second{0};
  };
  std::map<uint32_t, Moments> exact;
  const int fine = 24;
  for (uint32_t t = 0; t < g.triangles.size(); ++t) {
    for (int i = 0; i < fine; ++i) {
      for (int j = 0; j + i < fine; ++j) {
        for (int half = 0; half < (i + j + 1 < fine ? 2 : 1); ++half) {
          const float b1 = float((i + (half ? 2 / 3. : 1 / 3.)) / fine),
                      b2 = float((j + (half ? 2 / 3. : 1 / 3.)) / fine);
          const double area = area_of(g, t) / (fine * fine);
          const glm::dvec3 p = point_on(g, t, b1, b2);
          Moments& m = exact[layout.table[atlas_cell(layout.triangles[t], b1, b2)]];
          m.area += area, m.first += area * p, m.second += area * p * p;
        }
      }
    }
  }
  const double edge = double(layout.info.texel_edge);
  glm::dvec3 bias(0), spread(0);
  for (const auto& [texel, m] : exact) {
    glm::dvec3 first(0), second(0);
    for (uint32_t k = 0; k < count; ++k) {
      const AtlasSample& s = layout.samples[size_t{texel} * count + k];
      const glm::dvec3 p = point_on(g, s.triangle, s.b1, s.b2);
      first += p / double(count), second += p * p / double(count);
    }
    const glm::dvec3 mean = m.first / m.area;
    for (int axis = 0; axis < 3; ++axis) {
      CHECK(std::abs(first[axis] - mean[axis]) < 0.1 * edge);  // 4 standard errors of independent points are 0.072
      const double variance = m.second[axis] / m.area - mean[axis] * mean[axis];
      spread[axis] += second[axis] - first[axis] * first[axis] - variance;
      bias[axis] += variance;
    }
  }
  for (int axis = 0; axis < 3; ++axis) CHECK(std::abs(spread[axis]) < 0.02 * bias[axis]);
}
