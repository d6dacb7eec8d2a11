// SPDX-License-Identifier: Apache-2.0
// What must hold of every layout of the surface atlas, on the built-in scenes and on awkward triangles.
#include <algorithm>
#include <cstring>

#include "lucarium/base/error.h"
#include "lucarium/scene/builtin/scenes.h"
#include "support.h"
#include "tolerance.h"
#include "touch.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

AtlasLayout lay_out(const AtlasGeometry& g, uint64_t texels, unsigned threads = 0) {
  AtlasLayoutOptions options;
  options.texel_count = texels;
  options.threads = threads;
  return make_atlas_layout(g, options);
}

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

}  // namespace

TEST_CASE("built-in scenes") {
  for (const char* name : {"cornell", "room", "furnace", "atrium"}) {
    const AtlasGeometry g = geometry_of(make_builtin_scene(name));
    for (const uint64_t texels : {100, 3000, 60000}) {
      const std::string scene = name;
      CAPTURE(scene);
      CAPTURE(texels);
      const AtlasLayout layout = lay_out(g, texels);
      check_layout(g, layout);
      CHECK(bad_texels(g, layout).empty());
      // Thousands of separate parts keep a texel each, however few are wanted.
      if (g.triangles.size() < 1000 || texels > 10000)
        CHECK(double(layout.info.texel_count) == test::relative(double(texels), 0.13));
    }
  }
}

TEST_CASE("the same bits for any number of threads") {
  const AtlasGeometry g = geometry_of(make_builtin_scene("atrium"));
  const AtlasLayout one = lay_out(g, 50000, 1), two = lay_out(g, 50000, 2);
  CHECK(std::memcmp(&one.info, &two.info, sizeof one.info) == 0);
  CHECK(same_bytes(one.triangles, two.triangles));
  CHECK(same_bytes(one.table, two.table));
  CHECK(same_bytes(one.links, two.links));
  CHECK(same_bytes(one.texels, two.texels));
  CHECK(same_bytes(one.ranges, two.ranges));
  CHECK(same_bytes(one.pieces, two.pieces));
}

TEST_CASE("a texel edge instead of a count") {
  std::vector<glm::vec3> corners;
  add_floor(corners, 0, 0, 4, 3);
  AtlasLayoutOptions options;
  options.texel_edge = 0.1;
  const AtlasLayout layout = make_atlas_layout(soup(corners), options);
  CHECK(layout.info.texel_count == 1200);
  CHECK(layout.info.texel_edge == 0.1f);
  for (const AtlasTexel& texel : layout.texels) CHECK(double(texel.area) == test::relative(0.01, 0.01));
}

TEST_CASE("double-sided surfaces have twice the texel sides, fronts first") {
  std::vector<glm::vec3> corners;
  add_floor(corners, 0, 0, 1, 1);
  AtlasGeometry g = soup(corners);
  for (glm::vec3& p : corners) p.x += 5;
  const AtlasGeometry other = soup(corners);
  // Instance 0 reflects on one side, instance 1 on both.
  const uint32_t first = static_cast<uint32_t>(g.positions.size());
  g.positions.insert(g.positions.end(), other.positions.begin(), other.positions.end());
  g.normals.insert(g.normals.end(), other.normals.begin(), other.normals.end());
  for (const glm::uvec3& t : other.triangles) g.triangles.push_back(t + first), g.instance.push_back(1);
  g.two_sided = {0, 1};
  const AtlasLayout layout = lay_out(g, 300);
  CHECK(layout.info.texel_count == 300);
  CHECK(layout.info.double_sided_count == 100);
  for (uint32_t side = 0; side < 300; ++side) {
    CHECK(g.instance[layout.texels[side].triangle] == (side < 200 ? 1 : 0));
    if (side < 100) CHECK(std::memcmp(&layout.texels[side], &layout.texels[side + 100], sizeof(AtlasTexel)) == 0);
  }
  check_layout(g, layout, 2000);
}

TEST_CASE("awkward triangles keep texels") {
  std::vector<glm::vec3> corners;
  add_floor(corners, 0, 0, 1, 1);
  SUBCASE("without area, beside others and alone") {
    corners.insert(corners.end(), {{0, 0, 0}, {0.3f, 0, 0}, {1, 0, 0}});  // along an edge of the floor
    corners.insert(corners.end(), {{0, 0, 0}, {1, 0, 1}, {0, 0, 0}});     // its diagonal
    corners.insert(corners.end(), {{7, 7, 7}, {7, 7, 7}, {7, 7, 7}});
    corners.insert(corners.end(), {{7, 0, 0}, {8, 0, 0}, {9, 0, 0}});
  }
  SUBCASE("slivers and needles") {
    for (int i = 0; i < 50; ++i) {
      const float x = 2 + 0.01f * float(i), thin = std::pow(10.f, -0.2f * float(i));
      corners.insert(corners.end(), {{x, 0, 0}, {x, 0.001f * thin, 5}, {x + 0.003f * thin, 0, 0}});
    }
  }
  SUBCASE("tiny ones far from the origin") {
    for (int i = 0; i < 200; ++i) {
      const glm::vec3 p(1000 + 1e-3f * float(i), 1000, -1000);
      corners.insert(corners.end(), {p, p + glm::vec3(0, 0, 7e-4f), p + glm::vec3(7e-4f, 0, 0)});
    }
  }
  SUBCASE("not finite ones") {
    corners.insert(corners.end(), {{NAN, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    corners.insert(corners.end(), {{INFINITY, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    const AtlasLayout layout = lay_out(soup(corners), 100);
    for (uint32_t t = 0; t < 4; ++t)
      CHECK(layout.table[atlas_cell(layout.triangles[t], 0.3f, 0.3f)] < layout.info.texel_count);
    for (const AtlasTexel& texel : layout.texels) CHECK(std::isfinite(texel.area));
    return;
  }
  for (const bool two_sided : {false, true}) {
    const AtlasGeometry g = soup(corners, two_sided);
    for (const uint64_t texels : {1, 100, 20000}) {
      CAPTURE(texels);
      const AtlasLayout layout = lay_out(g, texels);
      check_sums(g, layout);
      CHECK(bad_texels(g, layout).empty());
      // A lone triangle without area has one texel wherever it reaches; nothing ever hits it.
      check_lookups(g, layout, 3000, [&](uint32_t t) { return area_of(g, t) > 0; });
    }
  }
}

TEST_CASE("triangles that nothing hits neither take texels nor make others longer") {
  std::vector<glm::vec3> corners;
  add_floor(corners, 0, 0, 1, 1);
  const AtlasLayout plain = lay_out(soup(corners), 400);
  for (int i = 0; i < 50; ++i) {
    const float y = 0.02f * float(i);
    corners.insert(corners.end(), {{0, y, 0}, {0.3f, y, 0}, {1, y, 0}});  // the first is along an edge of the floor
    corners.insert(corners.end(), {{0, 0, y}, {1, y, 1}, {0, 0, y}});     // its diagonal
    corners.insert(corners.end(), {{NAN, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  }
  const AtlasGeometry g = soup(corners);
  const AtlasLayout layout = lay_out(g, 400);
  CHECK(layout.info.texel_count == plain.info.texel_count);
  CHECK(layout.info.texel_edge == plain.info.texel_edge);
  CHECK(same_bytes(layout.texels, plain.texels));
  CHECK(same_bytes(layout.table, plain.table));
  CHECK(same_bytes(layout.pieces, plain.pieces));
  for (uint32_t t = 0; t < g.triangles.size(); ++t)
    CHECK(layout.table[atlas_cell(layout.triangles[t], 0.3f, 0.3f)] < layout.info.texel_count);
}

TEST_CASE("triangles that nothing hits change no texel of those behind them in the file") {
  std::vector<glm::vec3> floor, corners;
  add_floor(floor, 0, 0, 1, 1);
  const AtlasLayout plain = lay_out(soup(floor), 400);
  for (int i = 0; i < 51; ++i) {
    const float y = 0.02f * float(i);
    corners.insert(corners.end(), {{0, y, 0}, {0.3f, y, 0}, {1, y, 0}});
  }
  const uint32_t before = static_cast<uint32_t>(corners.size() / 3);
  corners.insert(corners.end(), floor.begin(), floor.end());
  AtlasLayout layout = lay_out(soup(corners), 400);
  CHECK(layout.info.texel_edge == plain.info.texel_edge);
  CHECK(same_bytes(layout.table, plain.table));
  CHECK(same_bytes(layout.links, plain.links));
  for (AtlasTexel& texel : layout.texels) texel.triangle -= before;
  for (TexelPiece& piece : layout.pieces) piece.triangle -= before;
  CHECK(same_bytes(layout.texels, plain.texels));
  CHECK(same_bytes(layout.pieces, plain.pieces));
}

TEST_CASE("slivers, however many, leave at least half of their texels to other surfaces") {
  std::vector<glm::vec3> corners;
  add_floor(corners, 0, 0, 1, 1);
  const AtlasLayout plain = lay_out(soup(corners), 400);
  for (const int slivers : {40, 400, 4000}) {
    CAPTURE(slivers);
    std::vector<glm::vec3> all = corners;
    for (int i = 0; i < slivers; ++i) {
      const float x = float(i % 50) / 50, z = float(i / 50) / 80;
      all.insert(all.end(), {{x, 1, z}, {x, 1, z + 0.01f}, {x + 1e-4f, 1, z}});
    }
    const AtlasLayout layout = lay_out(soup(all), 400);
    const double coarser = double(layout.info.texel_edge) / double(plain.info.texel_edge);
    MESSAGE(slivers, " slivers: edge ", coarser, ", texels ", layout.info.texel_count);
    CHECK(coarser < std::sqrt(2) * 1.08);
    // Slivers that touch nothing have a texel each, at any edge; the others keep half of the wanted number, to 8 %.
    const double others = double(layout.info.texel_count) - slivers;
    CHECK(others < 400 * 1.08);
    CHECK(others > 400 / 2 / 1.08);
    if (slivers < 50) CHECK(coarser == test::relative(1, 0.01));
  }
}

TEST_CASE("triangle soup: a texel each where there are enough") {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(-1.f, 1.f);
  std::vector<glm::vec3> corners;
  for (int i = 0; i < 3 * 2000; ++i) {
    const glm::vec3 center(float(i / 3 % 13), float(i / 39 % 13), float(i / 507));
    corners.push_back(center + 0.5f * glm::vec3(unit(random), unit(random), unit(random)));
  }
  const AtlasGeometry g = soup(corners);
  for (const uint64_t texels : {100, 30000}) {
    const AtlasLayout layout = lay_out(g, texels);
    check_layout(g, layout);
    CHECK(bad_texels(g, layout).empty());
  }
}

TEST_CASE("what a thin gap separates stays apart") {
  // A comb: strips joined at one end, 0.3 texels between them, at several offsets to the grid.
  for (const float offset : {0.f, 0.011f, 0.05f, 0.0999f}) {
    CAPTURE(offset);
    std::vector<glm::vec3> corners;
    add_floor(corners, 0, -1, 3 + offset, 0);
    for (int i = 0; i < 6; ++i) {
      const float x = offset + 0.5f * float(i);
      add_floor(corners, x, 0, x + 0.47f, 2);
    }
    AtlasGeometry g = soup(corners);
    // T-junctions part them; the same with a shared corner.
    g.positions[6] = g.positions[9] = glm::vec3(0, 0, 0);
    AtlasLayoutOptions options;
    options.texel_edge = 0.1;
    const AtlasLayout layout = make_atlas_layout(g, options);
    CHECK(bad_texels(g, layout).empty());
    check_layout(g, layout, 5000);
  }
  // One connected sheet bent round a slot: both lips share their far end only.
  const auto slit = [](float gap) {
    const std::vector<glm::vec3> p = {{0, 0, 0},       {0, 0, 2}, {1, 0, 2}, {1, 0, 1},
                                      {1 + gap, 0, 2}, {2, 0, 2}, {2, 0, 0}, {1, 0, 0}};
    const int fan[][3] = {{0, 1, 3}, {1, 2, 3}, {0, 3, 7}, {7, 3, 6}, {3, 5, 6}, {3, 4, 5}};
    std::vector<glm::vec3> corners;
    for (const auto& t : fan) corners.insert(corners.end(), {p[t[0]], p[t[1]], p[t[2]]});
    return soup(corners);
  };
  for (const float gap : {0.0001f, 0.02f, 0.05f, 0.2f}) {
    CAPTURE(gap);
    const AtlasGeometry g = slit(gap);
    AtlasLayoutOptions options;
    options.texel_edge = 0.1;
    const AtlasLayout layout = make_atlas_layout(g, options);
    CHECK(bad_texels(g, layout).empty());
    check_layout(g, layout, 5000);
  }
}

TEST_CASE("merging is a setting") {
  const AtlasGeometry g = geometry_of(make_builtin_scene("furnace"));
  AtlasLayoutOptions options;
  options.texel_edge = 0.05;
  uint32_t previous = 0;
  for (const double threshold : {0.5, 0.25, 0.}) {
    options.merge_threshold = threshold;
    const AtlasLayout layout = make_atlas_layout(g, options);
    check_layout(g, layout, 3000);
    CHECK(layout.info.texel_count > previous);
    previous = layout.info.texel_count;
  }
}

TEST_CASE("nothing to lay out, and options that cannot be had") {
  AtlasGeometry nothing;
  const AtlasLayout layout = lay_out(nothing, 100);
  CHECK(layout.info.texel_count == 0);
  CHECK(layout.table.empty());
  AtlasLayoutOptions options;
  options.texel_count = 0;
  CHECK_THROWS_AS(make_atlas_layout(nothing, options), Error);
  options.texel_edge = -1;
  CHECK_THROWS_AS(make_atlas_layout(nothing, options), Error);
  options = {};
  options.merge_threshold = 2;
  CHECK_THROWS_AS(make_atlas_layout(nothing, options), Error);
}

TEST_CASE("progress is reported and a build can be cancelled") {
  const AtlasGeometry g = geometry_of(make_builtin_scene("atrium"));
  AtlasLayoutOptions options;
  options.texel_count = 50000;
  std::vector<double> reported;
  options.progress = [&](double fraction, const std::string&) { reported.push_back(fraction); };
  make_atlas_layout(g, options);
  CHECK(reported.size() > 20);
  CHECK(std::is_sorted(reported.begin(), reported.end()));
  for (const size_t after : {size_t{0}, size_t{5}, size_t{15}}) {
    size_t asked = 0;
    options.cancelled = [&] { return asked++ >= after; };
    try {
      make_atlas_layout(g, options);
      FAIL("not cancelled");
    } catch (const Error& error) {
      CHECK(error.error_class() == ErrorClass::interrupted);
    }
  }
}
