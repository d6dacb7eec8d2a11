// SPDX-License-Identifier: Apache-2.0
// Rough surfaces whose cells are of a coarser grid of directions (dir_levels).
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "lamp_box.h"
#include "lucarium/scene/look_at.h"
#include "technique_rig.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using test::LampBox;
using test::relative;

namespace {

/// The box with a lamp, its wall +x metal of that roughness.
Scene metal_box(float roughness) {
  Scene scene = LampBox().scene();
  for (SceneMaterial& material : scene.materials)
    if (material.metallic > 0) material.roughness = roughness;
  return scene;
}

vlf::Parameters levels_field(int levels, int dir_n = 8) {
  vlf::Parameters parameters;
  parameters.dir_n = dir_n;
  parameters.dir_levels = levels;
  parameters.cells = 32;
  parameters.texels = 2400;
  parameters.supersample = vlf::Supersample::four;
  parameters.residual = 0.001f;
  return parameters;
}

std::vector<double> walls(const test::FieldRig& rig) {
  std::vector<double> result;
  for (int wall = 0; wall <= LampBox::kLamp; ++wall) result.push_back(rig.mean(rig.all(), wall));
  return result;
}

/// The greatest relative difference.
double farthest(const std::vector<double>& found, const std::vector<double>& expected) {
  double result = 0;
  for (size_t i = 0; i < found.size(); ++i) result = std::max(result, std::abs(found[i] / expected[i] - 1));
  return result;
}

}  // namespace

TEST_CASE("lines of a level are those of the coarser grid") {
  for (const uint32_t n : {4u, 8u, 12u}) {
    CAPTURE(n);
    const vlf::DirectionGrid grid(n, 5);
    const std::vector<uint32_t> levels = grid.levels(2);
    for (const uint32_t level : {1u, 2u}) {
      if (n >> level < 2) continue;
      CAPTURE(level);
      const vlf::DirectionGrid coarse(n >> level, 5);
      CHECK(std::count_if(levels.begin(), levels.end(), [&](uint32_t l) { return l >= level; }) == coarse.lines());
      for (uint32_t line = 0; line < coarse.lines(); ++line) {
        double nearest = 0;
        for (uint32_t l = 0; l < grid.lines(); ++l)
          if (levels[l] >= level)
            nearest = std::max(nearest, std::abs(glm::dot(coarse.direction(2 * line), grid.direction(2 * l))));
        CHECK(nearest > 1 - 1e-12);
      }
    }
  }
}

TEST_CASE("a surface takes the coarsest grid whose directions are as near as its lobes are wide") {
  vlf::PatchOptions options;
  options.dir_n = 16;
  options.levels = 3;
  for (const uint32_t level : {1u, 2u, 3u}) {
    const double spacing = vlf::DirectionGrid::spacing(16 >> level);
    CHECK(vlf::level_of(1.001 * spacing, options) == level);
    CHECK(vlf::level_of(0.999 * spacing, options) == level - 1);
  }
  CHECK(vlf::level_of(0, options) == 0);
  options.levels = 1;
  CHECK(vlf::level_of(1, options) == 1);
  options.levels = 3;
  options.dir_n = 12;  // 12, 6, 3
  CHECK(vlf::level_of(1, options) == 2);
  options.dir_n = 7;
  CHECK(vlf::level_of(1, options) == 0);
}

TEST_CASE("mirrors and narrow lobes have the bits of a field without levels") {
  for (const float roughness : {0.f, 0.4f}) {
    CAPTURE(roughness);
    test::FieldRig without(metal_box(roughness), levels_field(0)), with(metal_box(roughness), levels_field(3));
    CHECK(with.field().maps().coarse_cells() == 0);
    without.propagate();
    with.propagate();
    CHECK(with.field().total().download() == without.field().total().download());
    CHECK(with.all() == without.all());
  }
}

TEST_CASE("a level has a quarter of the cells, in memory too, and the light that a field without it has") {
  // GGX widths .64 and .9 at spacings of .436 (n = 4) and .836 (n = 2).
  // Nine lines are the fewest that there can be.
  for (const auto& [roughness, level, tolerance] : {std::tuple{0.8f, 1u, 0.01}, std::tuple{0.95f, 2u, 0.025}}) {
    CAPTURE(roughness);
    test::FieldRig without(metal_box(roughness), levels_field(0));
    without.propagate();
    const std::vector<double> expected = walls(without);
    const double cells = without.field().maps().cells();
    // All on the coarser grid: what a level must not be worse than.
    test::FieldRig coarse(metal_box(roughness), levels_field(0, 8 >> level));
    coarse.propagate();
    const double allowed = farthest(walls(coarse), expected);
    const auto rendering = static_cast<double>(without.field().counts().rendering_bytes);
    struct Case {
      int perturb;
      vlf::Store store;
    };
    for (const auto& [perturb, store] :
         {Case{1, vlf::Store::tiles}, Case{1, vlf::Store::csr}, Case{3, vlf::Store::tiles}}) {
      CAPTURE(perturb);
      vlf::Parameters parameters = levels_field(static_cast<int>(level));
      parameters.perturb = perturb;
      parameters.store = store;
      test::FieldRig with(metal_box(roughness), parameters);
      for (const FieldFacet& facet : with.surfaces().patches.facets) CHECK(facet.level == level);
      const vlf::TileMaps& maps = with.field().maps();
      CHECK(maps.info().first_coarse == 0);
      const double n = 8 >> level;
      if (store == vlf::Store::tiles) {
        CHECK(maps.cells() / cells == relative((4 * n * n + 2) / (4 * 8 * 8 + 2), 0.08));
        CHECK(static_cast<double>(with.field().counts().rendering_bytes) < 1.2 * rendering / std::exp2(2. * level));
      }
      with.propagate();
      const std::vector<double> found = walls(with);
      const double off = farthest(found, expected);
      MESSAGE("level ", level, ", perturb ", perturb, ": walls off by up to ", off, ", on the coarser grid ", allowed);
      CHECK(off < tolerance);
      CHECK(off < allowed);
    }
  }
}

TEST_CASE("surfaces with and without a level stand beside each other, and in pictures") {
  // The wall -x is a mirror, +x rough metal.
  Scene scene = metal_box(0.8f);
  scene.materials[static_cast<size_t>(scene.instances[0].material)] = test::mirror(0.8f);
  scene.cameras.push_back(look_at_camera("inside", {0.3f, 0.6f, 0.9f}, {0.9f, 0.4f, 0.2f}, 80.f));
  const test::Options options = {{"dir_n", "8"},     {"cells", "32"},           {"texels", "2400"},
                                 {"preview", "off"}, {"preset", "walkthrough"}, {"inspect_line", "5"}};
  std::vector<double> means, subfields, cells;
  for (const char* levels : {"0", "1"}) {
    const auto run = test::session(scene, -1, test::with(options, {{"dir_levels", levels}}));
    run->finish_light();
    run->run({.samples = 4});
    means.push_back(test::mean(run->resolve().image()));
    subfields.push_back(test::mean(run->resolve().find("subfield")->pixels));
    cells.push_back(run->technique().counters().at("cells"));
  }
  MESSAGE("cells ", cells[0], " and ", cells[1], ", mean of the picture ", means[0], " and ", means[1]);
  CHECK(cells[1] < 0.7 * cells[0]);
  CHECK(means[1] == relative(means[0], 0.02));
  CHECK(subfields[1] == relative(subfields[0], 0.02));
}
