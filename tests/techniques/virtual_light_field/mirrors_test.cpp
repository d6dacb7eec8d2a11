// SPDX-License-Identifier: Apache-2.0
// Facets: mirrors, glossy lobes and glass, by closed forms on the diffuse surfaces that they light.
#include <doctest/doctest.h>

#include <algorithm>

#include "field_rig.h"
#include "lucarium/scene/builtin/builder.h"
#include "test_support.h"
#include "tolerance.h"
#include "virtual_light_field/tiles/describe_tiles.h"

using namespace lucarium;
using test::relative;
using test::within;

namespace {

vlf::Parameters mirror_field(int dir_n, int cells, int texels) {
  vlf::Parameters parameters;
  parameters.dir_n = dir_n;
  parameters.cells = cells;
  parameters.texels = texels;
  parameters.direct_mode = vlf::DirectMode::exchange;
  return parameters;
}

}  // namespace

TEST_CASE("a furnace with a mirror for a wall is a furnace") {
  const SceneMaterial wall = test::emitter(1, 0.5f);
  vlf::Parameters parameters = mirror_field(8, 32, 2048);
  parameters.tail = false;
  parameters.residual = 0;
  test::FieldRig rig(test::unit_box({{0, wall}, {2, wall}, {3, wall}, {4, wall}, {5, wall}, {1, test::mirror()}}),
                     parameters);
  rig.propagate(40);
  CHECK(rig.field().maps().info().facets == 1);
  CHECK(rig.mean(rig.all(), 1) > 1.999);
  CHECK(rig.mean(rig.all(), 1) < 2.001);
  CHECK(test::min_of(rig.of_instance(rig.all(), 1)) > 1.99);

  // What inspect() reports: half of all directions leave the mirror, Lambert's walls have no facet.
  const std::vector<uint32_t> instances = rig.instances();
  const auto side_of = [&](uint32_t instance) {
    return static_cast<uint32_t>(std::find(instances.begin(), instances.end(), instance) - instances.begin());
  };
  const auto rows = vlf::describe_tiles(rig.field().maps(), side_of(5));
  REQUIRE(rows.size() == 3);
  CHECK(rows[0].second == "0 of 1");
  CHECK(rows[1].second == "129 of 258");
  CHECK(rows[2].second != "0");
  CHECK(vlf::describe_tiles(rig.field().maps(), side_of(0)).size() == 1);
}

TEST_CASE("cells of a lobe that no direction of a coarse grid lies in are not black") {
  const SceneMaterial wall = test::emitter(1, 0.5f);
  for (const uint64_t seed : {1, 2, 3}) {
    CAPTURE(seed);
    vlf::Parameters parameters = mirror_field(2, 16, 512);
    parameters.split_layers = false;
    test::FieldRig rig(
        test::unit_box({{0, wall}, {2, wall}, {3, wall}, {4, wall}, {5, wall}, {1, test::mirror(1, 0.27f)}}),
        parameters, {.max_bounces = 2, .seed = seed});
    rig.propagate();
    const std::vector<uint32_t> cells = rig.field().total().download();
    CHECK(std::count(cells.begin(), cells.end(), FIELD_NO_CELL) < static_cast<ptrdiff_t>(cells.size()));
    CHECK(std::count(cells.begin(), cells.end(), 0u) == 0);
  }
}

TEST_CASE("light by a mirror is that of the image lamp") {
  const SceneMaterial black = test::lambert(0);
  test::FieldRig rig(test::unit_box({{2, black}, {0, black}, {3, test::emitter(1)}, {1, test::mirror()}}),
                     mirror_field(16, 64, 4096), {.max_bounces = 1});
  rig.propagate();
  // Form factors of parallel and perpendicular squares, and those of the lamp behind the mirror.
  CHECK(rig.mean(rig.direct(), 0) == relative(0.199825, 0.01));
  CHECK(rig.mean(rig.all(), 0) == relative(0.199825 + 0.086050, 0.005));
  CHECK(rig.mean(rig.all(), 1) == relative(0.200044 + 0.032809, 0.005));
}

TEST_CASE("glossy and refracting walls keep a uniform field") {
  const SceneMaterial wall = test::emitter(1, 0);
  for (const float roughness : {0.2f, 0.45f, 0.8f}) {
    CAPTURE(roughness);
    test::FieldRig rig(
        test::unit_box({{0, wall}, {2, wall}, {3, wall}, {4, wall}, {5, wall}, {1, test::mirror(1, roughness)}}),
        mirror_field(8, 32, 2048), {.max_bounces = 0});
    rig.propagate();
    // What a cell sends is the albedo of its lobe, which loses what bounces twice between microfacets.
    std::vector<uint32_t> direct = rig.field().direct().download();
    double most = 0;
    uint64_t known = 0;
    for (const uint32_t bits : direct) {
      if (bits == FIELD_NO_CELL) continue;
      ++known;
      most = std::max(most, static_cast<double>(bits & 511) * std::exp2(static_cast<double>(bits >> 27) - 24) /
                                static_cast<double>(rig.field().scale()));
    }
    CHECK(known > 1000);
    CHECK(most <= 1.0 + 1. / 256);
    CHECK(most > 0.6);
  }
}

TEST_CASE("clear glass in a furnace changes nothing outside of it") {
  const SceneMaterial wall = test::emitter(1, 0.5f);
  for (const float roughness : {0.f, 0.3f}) {
    for (const bool thin : {true, false}) {
      CAPTURE(roughness);
      CAPTURE(thin);
      Scene scene = test::unit_box({{0, wall}, {1, wall}, {2, wall}, {3, wall}, {4, wall}, {5, wall}});
      SceneMaterial glass;
      glass.base_color = glm::vec4(1);
      glass.metallic = 0;
      glass.roughness = roughness;
      glass.transmission = 1;
      glass.thickness = thin ? 0.f : 1.f;
      const int material = test::add_material(scene, glass);
      add_instance(scene, add_mesh(scene, MeshBuilder("block").box({0.3f, 0.2f, 0.35f}, {0.7f, 0.6f, 0.7f}).take()),
                   material);
      vlf::Parameters parameters = mirror_field(test::full_run() ? 16 : 8, 64, 4096);
      parameters.residual = 0.001f;
      test::FieldRig rig(std::move(scene), parameters);
      rig.propagate();
      // Rough glass loses what would bounce twice between microfacets: nothing is gained in exchange.
      for (int k = 0; k < 6; ++k) {
        const double e = rig.mean(rig.all(), k);
        if (roughness > 0)
          CHECK((e > 1.93 && e < 2));
        else
          CHECK(e == relative(2, 0.01));
      }
    }
  }
}
