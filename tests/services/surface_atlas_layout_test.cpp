// SPDX-License-Identifier: Apache-2.0
// What must hold of every layout of the surface atlas, on the built-in scenes and on awkward triangles.
#include <algorithm>
#include <map>

#include "surface_atlas_support.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// Texel areas sum to the surface's, slots are numbered as said, pieces cover every triangle once.
void check_sums(const AtlasGeometry& g, const AtlasLayout& layout) {
  const AtlasInfo& info = layout.info;
  REQUIRE(layout.texels.size() == info.texel_count);
  REQUIRE(layout.table.size() == info.cell_count);
  REQUIRE(2 * info.double_sided_count <= info.texel_count);
  double area = 0;
  for (const AtlasTexel& texel : layout.texels) area += double(texel.area);
  CHECK(area == doctest::Approx(side_area(g)).epsilon(1e-6));
  std::vector<double> covered(g.triangles.size(), 0);
  for (uint32_t slot = 0; slot < info.texel_count; ++slot) {
    const bool two_sided = slot < 2 * info.double_sided_count;
    const bool back = two_sided && slot >= info.double_sided_count;
    double texel_area = 0;
    const uint2 range = layout.ranges[slot];
    for (uint32_t i = range.x; i < range.x + range.y; ++i) {
      const AtlasPiece& piece = layout.pieces[i];
      REQUIRE(bool(g.two_sided[g.instance[piece.triangle]]) == two_sided);
      if (!back) covered[piece.triangle] += double(piece.fraction);
      texel_area += double(piece.fraction) * area_of(g, piece.triangle);
    }
    CHECK(texel_area == doctest::Approx(double(layout.texels[slot].area)).epsilon(1e-5));
  }
  for (uint32_t t = 0; t < covered.size(); ++t) CHECK_MESSAGE(std::abs(covered[t] - 1) < 1e-5, "triangle " << t);
}

/// Every point finds a texel that has a piece of its triangle, or of one that touches it, within reach.
void check_lookups(const AtlasGeometry& g, const AtlasLayout& layout, uint32_t points) {
  std::mt19937 random(7);
  const double reach = 4 * double(layout.info.texel_edge);
  uint32_t strangers = 0;
  for (uint32_t i = 0; i < points; ++i) {
    const uint32_t t = static_cast<uint32_t>(random() % g.triangles.size());
    const RandomPoint p = random_point(random);
    const uint32_t cell = atlas_cell(layout.triangles[t], p.b1, p.b2);
    REQUIRE(cell < layout.table.size());
    const uint32_t texel = layout.table[cell];
    REQUIRE_MESSAGE(texel != LUCARIUM_NONE, "triangle " << t << " at " << p.b1 << ", " << p.b2);
    const bool two_sided = g.two_sided[g.instance[t]];
    REQUIRE((two_sided ? texel < layout.info.double_sided_count
                       : texel >= 2 * layout.info.double_sided_count && texel < layout.info.texel_count));
    const AtlasTexel& sample = layout.texels[texel];
    REQUIRE(g.instance[sample.triangle] == g.instance[t]);
    const glm::dvec3 at = point_on(g, t, p.b1, p.b2), from = point_on(g, sample.triangle, sample.b1, sample.b2);
    CHECK_MESSAGE(glm::length(at - from) < reach, "triangle " << t << ", texel " << texel);
    const uint2 range = layout.ranges[texel];
    const bool own = std::any_of(layout.pieces.begin() + range.x, layout.pieces.begin() + range.x + range.y,
                                 [&](const AtlasPiece& piece) { return piece.triangle == t; });
    strangers += !own;
  }
  CHECK(strangers < points / 10);
}

void check_layout(const AtlasGeometry& g, const AtlasLayout& layout, uint32_t points = 20000) {
  check_sums(g, layout);
  check_lookups(g, layout, points);
}

}  // namespace

TEST_CASE("built-in scenes") {
  for (const char* name : {"cornell", "room", "furnace"}) {
    for (const uint64_t texels : {100, 3000, 60000}) {
      CAPTURE(name);
      CAPTURE(texels);
      const AtlasGeometry g = geometry_of(make_builtin_scene(name));
      AtlasLayoutOptions options;
      options.texel_count = texels;
      const AtlasLayout layout = make_atlas_layout(g, options);
      MESSAGE(name << " " << texels << ": " << layout.info.texel_count << " slots, " << layout.charts.size() << " charts");
      check_layout(g, layout);
    }
  }
}
