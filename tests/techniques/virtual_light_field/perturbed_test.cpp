// SPDX-License-Identifier: Apache-2.0
// Perturbed directions, which stand for those of the grid, and fragments that are kept from sweep to sweep.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "field_rig.h"
#include "invisible_sheet.h"
#include "lucarium/base/numbers.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using test::relative;
using test::within;

namespace {

vlf::Parameters field(int dir_n, int cells, int texels, int perturb) {
  vlf::Parameters parameters;
  parameters.dir_n = dir_n;
  parameters.cells = cells;
  parameters.texels = texels;
  parameters.perturb = perturb;
  parameters.direct_mode = vlf::DirectMode::exchange;
  return parameters;
}

Scene mirror_furnace() {
  const SceneMaterial wall = test::emitter(1, 0.5f);
  return test::unit_box({{0, wall}, {2, wall}, {3, wall}, {4, wall}, {5, wall}, {1, test::mirror()}});
}

/// A plate above a floor, under a sky: columns side by side have one surface or two, and rays end behind each.
Scene plates_under_sky() {
  Scene scene;
  const int material = test::add_material(scene, test::lambert(0.5f));
  const auto plate = [&](float low, float high, float y) {
    test::add_polygon(scene, {{low, y, low}, {low, y, high}, {high, y, high}, {high, y, low}}, material);
  };
  plate(0, 1, 0);
  plate(0.3f, 0.7f, 0.4f);
  Environment sky;
  sky.width = sky.height = 4;
  sky.radiance.assign(16, glm::vec3(1));
  scene.environment = sky;
  return scene;
}

/// A room with a wall of rough metal. A block is sunk into its floor, so that hidden parts of the floor meet the
/// block's backs, and clear glass hovers over the floor beside it and before the metal.
Scene block_and_glass() {
  const SceneMaterial wall = test::emitter(1, 0.5f);
  Scene scene = test::unit_box({{0, wall}, {2, wall}, {3, wall}, {4, wall}, {5, wall}, {1, test::mirror(0.9f, 0.8f)}});
  add_instance(scene, add_mesh(scene, MeshBuilder("block").box({0.1f, -0.2f, 0.1f}, {0.43f, 0.3f, 0.47f}).take()),
               test::add_material(scene, test::lambert(0.5f)));
  const int glass = test::add_material(scene, test::invisible_glass());
  test::add_polygon(scene, {{0.52f, 0.03f, 0.9f}, {0.9f, 0.03f, 0.9f}, {0.9f, 0.03f, 0.3f}, {0.52f, 0.03f, 0.3f}},
                    glass);
  test::add_polygon(scene, {{0.97f, 0.4f, 0.3f}, {0.97f, 0.4f, 0.8f}, {0.97f, 0.8f, 0.8f}, {0.97f, 0.8f, 0.3f}}, glass);
  return scene;
}

/// The bits of all that a field shows.
std::vector<uint32_t> bits_of(const test::FieldRig& rig) {
  std::vector<uint32_t> result = rig.field().total().download();
  for (const TypedBuffer<float4>* buffer : {&rig.field().shown_direct(), &rig.field().shown()}) {
    const std::vector<float4> values = buffer->download();
    const auto* words = reinterpret_cast<const uint32_t*>(values.data());
    result.insert(result.end(), words, words + 4 * values.size());
  }
  return result;
}

}  // namespace

TEST_CASE("perturbed directions cover the sphere uniformly, near the direction they stand for") {
  for (const uint32_t n : {2u, 5u}) {
    CAPTURE(n);
    constexpr uint32_t count = 8192;
    const vlf::DirectionGrid grid(n, 5);
    glm::dmat3 second(0);
    double farthest = 0;
    for (uint32_t line = 0; line < grid.lines(); ++line) {
      const std::vector<glm::dvec3> directions = grid.directions_about(line, count, 7);
      REQUIRE(directions.size() == count);
      for (const glm::dvec3& d : directions) {
        farthest = std::max(farthest, std::acos(std::min(1., glm::dot(d, grid.direction(2 * line)))));
        second += 2 * grid.solid_angle(2 * line) / count * glm::outerProduct(d, d);
      }
    }
    // The integral of ω ωᵀ over the sphere is 4 π / 3 times the unit matrix.
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) CHECK(second[c][r] == within(r == c ? 4 * pi / 3 : 0, 0.01));
    CHECK(farthest < 2 * grid.spacing());
    CHECK(farthest > 0.7 * grid.spacing());
  }
}

TEST_CASE("directions of one pass about those of the grid are as even as a grid, not drawn one by one") {
  // Of parallel unit squares at distance 1, turned at random, their form factor by one direction about each line. Drawn
  // one by one they miss it by 4.6 %.
  constexpr uint32_t n = 8, count = 4;
  std::mt19937 random(3);
  std::normal_distribution<double> gauss;
  const vlf::DirectionGrid grid(n, 5);
  double squares = 0;
  int tries = 0;
  for (uint64_t seed = 1; seed <= 25; ++seed) {
    std::vector<std::vector<glm::dvec3>> passes(count);
    for (uint32_t line = 0; line < grid.lines(); ++line) {
      const std::vector<glm::dvec3> directions = grid.directions_about(line, count, seed);
      for (uint32_t i = 0; i < count; ++i) passes[i].push_back(directions[i]);
    }
    for (const std::vector<glm::dvec3>& pass : passes) {
      const glm::dvec3 z = glm::normalize(glm::dvec3(gauss(random), gauss(random), gauss(random)));
      const glm::dvec3 x = glm::normalize(glm::cross(z, glm::dvec3(0.3, 0.5, 0.8))), y = glm::cross(z, x);
      double sum = 0;
      for (uint32_t line = 0; line < grid.lines(); ++line) {
        const glm::dvec3 d(glm::dot(pass[line], x), glm::dot(pass[line], y), std::abs(glm::dot(pass[line], z)));
        if (d.z < 1e-6) continue;
        sum += grid.solid_angle(2 * line) * d.z * std::max(0., 1 - std::abs(d.x) / d.z) *
               std::max(0., 1 - std::abs(d.y) / d.z) / pi;
      }
      squares += std::pow(sum / 0.199825 - 1, 2);
      ++tries;
    }
  }
  CHECK(std::sqrt(squares / tries) < 0.025);
}

TEST_CASE("perturbed rays keep a uniform field and form factors") {
  const SceneMaterial lamp = test::emitter(1);
  test::FieldRig box(test::unit_box({{0, lamp}, {1, lamp}, {2, lamp}, {3, lamp}, {4, lamp}, {5, lamp}}),
                     field(3, 32, 1024, 3), {.max_bounces = 0});
  box.propagate();
  CHECK(test::min_of(box.direct()) == within(1, 1e-5));
  const SceneMaterial black = test::lambert(0);
  for (const bool parallel : {true, false}) {
    CAPTURE(parallel);
    test::FieldRig rig(test::unit_box({{2, black}, {parallel ? 3 : 0, lamp}}),
                       field(test::full_run() ? 16 : 6, 32, 1024, 16), {.max_bounces = 0});
    rig.propagate();
    CHECK(rig.mean(rig.direct(), 0) == relative(parallel ? 0.199825 : 0.200044, 0.01));
  }
}

TEST_CASE("perturbed rays by a mirror bring the light of the image lamp, and leave a furnace alone") {
  const SceneMaterial black = test::lambert(0);
  for (const vlf::SendInterpolation send : {vlf::SendInterpolation::bary, vlf::SendInterpolation::cell}) {
    CAPTURE(static_cast<int>(send));
    // Light by the mirror is blurred by the spacing of directions three times, as it arrives, is reflected and leaves:
    // what the floor loses of it the wall gains.
    vlf::Parameters parameters = field(test::full_run() ? 16 : 12, 32, 1024, test::full_run() ? 9 : 4);
    parameters.send_interp = send;
    test::FieldRig rig(test::unit_box({{2, black}, {0, black}, {3, test::emitter(1)}, {1, test::mirror()}}), parameters,
                       {.max_bounces = 1});
    rig.propagate();
    CHECK(rig.mean(rig.all(), 0) == relative(0.199825 + 0.086050, 0.01));
    CHECK(rig.mean(rig.all(), 1) == relative(0.200044 + 0.032809, 0.01));
  }
  vlf::Parameters parameters = field(5, 32, 1024, 2);
  parameters.tail = false;
  parameters.residual = 0;
  test::FieldRig rig(mirror_furnace(), parameters);
  rig.propagate(20);
  CHECK(rig.mean(rig.all(), 1) == within(2, 0.002));
  CHECK(test::min_of(rig.of_instance(rig.all(), 1)) > 1.99);
}

TEST_CASE("kept fragments give the bits of drawn ones, all or some of them kept") {
  for (const auto& [perturb, scene] :
       {std::pair{1, mirror_furnace()}, std::pair{2, mirror_furnace()}, std::pair{1, plates_under_sky()}}) {
    CAPTURE(perturb);
    CAPTURE(scene.materials.size());
    const auto bits = [&, perturb = perturb, &scene = scene](int megabytes, size_t bytes, uint32_t* kept,
                                                             uint64_t* subfields) {
      vlf::Parameters parameters = field(4, 32, 1024, perturb);
      parameters.cache_visibility = megabytes;
      test::FieldRig rig(scene, parameters, {.max_bounces = 3, .cache_bytes = bytes});
      rig.propagate();
      *kept = static_cast<uint32_t>(rig.field().counts().kept_subfields);
      *subfields = rig.field().counts().subfields;
      return bits_of(rig);
    };
    uint32_t kept = 0;
    uint64_t subfields = 0;
    const std::vector<uint32_t> drawn = bits(0, 0, &kept, &subfields);
    CHECK(kept == 0);
    CHECK(drawn == bits(512, 0, &kept, &subfields));
    CHECK(4 * kept == subfields);
    CHECK(drawn == bits(512, 1u << 17, &kept, &subfields));
    CHECK(kept > 0);
    CHECK(4 * kept < subfields);
  }
}

TEST_CASE("kept fragments give the bits of drawn ones where texels have halves, cells are coarse and parts hidden") {
  vlf::Parameters parameters = field(6, 32, 1024, 1);
  parameters.dir_levels = 1;
  const auto bits = [&](int megabytes) {
    parameters.cache_visibility = megabytes;
    test::FieldRig rig(block_and_glass(), parameters, {.max_bounces = 3});
    rig.propagate();
    const auto& surfaces = rig.surfaces();
    REQUIRE(surfaces.accessibility.side_halves().two());
    REQUIRE(rig.field().maps().coarse_cells() > 0);
    const std::vector<float2> shares = surfaces.interior.shares().download();
    REQUIRE(std::any_of(shares.begin(), shares.end(), [](const float2& s) { return s.y < 1; }));
    CHECK((rig.field().counts().kept_subfields > 0) == (megabytes > 0));
    return bits_of(rig);
  };
  CHECK(bits(0) == bits(512));
}

TEST_CASE("rows of cells hold what tiles hold, in fewer cells") {
  const auto rig_of = [](vlf::Store store) {
    vlf::Parameters parameters = field(5, 64, 1024, 1);
    parameters.store = store;
    auto rig =
        std::make_unique<test::FieldRig>(mirror_furnace(), parameters, test::FieldRig::Options{.max_bounces = 2});
    rig->propagate();
    return rig;
  };
  const auto tiles = rig_of(vlf::Store::tiles), rows = rig_of(vlf::Store::csr);
  // Totals are rounded at random by the number of their cell; irradiance is the same.
  CHECK(tiles->all() == rows->all());
  CHECK(rows->field().maps().cells() < 0.85 * tiles->field().maps().cells());
  // As of tiles of one cell, which reach a cell farther on each side.
  const FieldInfo& info = rows->field().maps().info();
  const double c = static_cast<double>(info.cell), edge = 1 + 2 * c;
  CHECK(rows->field().maps().cells() == relative(info.lines * vlf::expected_cells(edge * edge, 4 * edge, c, 1), 0.1));
}

TEST_CASE("splats divided by their columns keep a furnace with a mirror, the paper's do not") {
  for (const vlf::ScatterMode mode : {vlf::ScatterMode::splat, vlf::ScatterMode::splat_raw}) {
    vlf::Parameters parameters = field(8, 32, 1024, 1);
    parameters.scatter = mode;
    parameters.tail = false;
    parameters.residual = 0;
    test::FieldRig rig(mirror_furnace(), parameters);
    rig.propagate(24);
    const double mean = rig.mean(rig.all(), 1), minimum = test::min_of(rig.of_instance(rig.all(), 1));
    if (mode == vlf::ScatterMode::splat) {
      CHECK(mean == within(2, 0.001));
      CHECK(minimum > 1.99);
    } else {  // power is kept in the mean, radiance is not
      CHECK(mean == within(2, 0.05));
      CHECK(minimum < 1.98);
    }
  }
}

TEST_CASE("cells take the bytes that are stated, propagating and displayed") {
  vlf::Parameters parameters = field(8, 128, 2048, 1);
  parameters.split_layers = false;
  parameters.tile = 0;
  test::FieldRig rig(mirror_furnace(), parameters, {.max_bounces = 1});
  const auto held = [&] { return rig.device().memory().by_owner().at(vlf::technique_name); };
  const double cells = rig.field().maps().cells();
  const size_t before = held();
  CHECK(static_cast<double>(rig.field().counts().propagating_bytes) / cells <= 18);
  rig.propagate();
  CHECK(static_cast<double>(rig.field().counts().rendering_bytes) / cells <= 4.6);
  CHECK(before - held() > rig.field().counts().propagating_bytes - rig.field().counts().rendering_bytes);
}
