// SPDX-License-Identifier: Apache-2.0
// The grid of directions: solid angles, antipodes, nesting, quadrature, hat functions; patches and the cells that they
// take.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "field_rig.h"
#include "lucarium/base/numbers.h"
#include "lucarium/scene/builtin/builder.h"
#include "lucarium/scene/load/load_scene.h"
#include "tolerance.h"
#include "virtual_light_field/directions/direction_grid.h"

using namespace lucarium;
using test::relative;
using test::within;

namespace {

/// Relative error of the grid's integral of the cosine over hemispheres: root mean square over random normals.
double cosine_error(uint32_t n) {
  std::mt19937 random(7);
  std::normal_distribution<double> gauss;
  double sum = 0;
  int count = 0;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const vlf::DirectionGrid grid(n, seed);
    for (int i = 0; i < 50; ++i, ++count) {
      const glm::dvec3 normal = glm::normalize(glm::dvec3(gauss(random), gauss(random), gauss(random)));
      double integral = 0;
      for (uint32_t d = 0; d < grid.directions(); ++d)
        integral += grid.solid_angle(d) * std::max(0., glm::dot(normal, grid.direction(d)));
      sum += std::pow(integral / pi - 1, 2);
    }
  }
  return std::sqrt(sum / count);
}

/// The hat functions that are not 0 at a direction, by the number of theirs: barycentric coordinates in the square.
std::map<uint32_t, double> hats_at(const vlf::DirectionGrid& grid, const glm::dvec3& direction) {
  const glm::dvec3 d = grid.rotation() * direction;
  const double r = std::sqrt(std::max(0., 1 - std::abs(d.z)));
  double v = r * 2 / pi * std::atan2(std::abs(d.y), std::abs(d.x)), u = r - v;
  if (d.z < 0) {
    const double before = u;
    u = 1 - v;
    v = 1 - before;
  }
  const double n = grid.n(), across = n * (1 + std::copysign(u, d.x)), down = n * (1 + std::copysign(v, d.y));
  const double i = std::clamp(std::floor(across), 0., 2 * n - 1), j = std::clamp(std::floor(down), 0., 2 * n - 1);
  double x = across - i, y = down - j;
  const bool mirrored = (i < n) != (j < n);  // the other diagonal splits these cells
  if (mirrored) x = 1 - x;
  std::map<uint32_t, double> hats;
  const auto add = [&](bool right, bool lower, double weight) {
    const double column = i + (right != mirrored ? 1 : 0), row = j + (lower ? 1 : 0);
    hats[grid.nodes().at(static_cast<size_t>(row * (2 * n + 1) + column))] += weight;
  };
  if (x + y < 1)
    add(false, false, 1 - x - y);
  else
    add(true, true, x + y - 1);
  add(true, false, x + y < 1 ? x : 1 - y);
  add(false, true, x + y < 1 ? y : 1 - x);
  return hats;
}

}  // namespace

TEST_CASE("directions: solid angles sum to 4 pi, every direction has its opposite, every node is a direction") {
  for (const uint32_t n : {2u, 3u, 8u, 16u}) {
    CAPTURE(n);
    const vlf::DirectionGrid grid(n, 3);
    CHECK(grid.directions() == 4 * n * n + 2);
    double sum = 0, opposite = 0;
    for (uint32_t d = 0; d < grid.directions(); ++d) {
      sum += grid.solid_angle(d);
      opposite = std::max(opposite, glm::length(grid.direction(d) + grid.direction(d ^ 1)));
      CHECK(glm::length(grid.direction(d)) == within(1, 1e-12));
    }
    CHECK(sum == relative(4 * pi, 1e-12));
    CHECK(opposite == 0);
    CHECK(grid.nodes().size() == (2 * n + 1) * (2 * n + 1));
    std::vector<int> uses(grid.directions(), 0);
    for (const uint32_t node : grid.nodes()) ++uses.at(node);
    for (const int use : uses) CHECK(use > 0);
  }
}

TEST_CASE("directions of a grid are every second node of the next") {
  const vlf::DirectionGrid coarse(4, 9), fine(8, 9);
  for (int v = 0; v <= 8; ++v)
    for (int u = 0; u <= 8; ++u)
      CHECK(glm::length(coarse.direction(coarse.nodes()[static_cast<size_t>(v * 9 + u)]) -
                        fine.direction(fine.nodes()[static_cast<size_t>(2 * v * 17 + 2 * u)])) == within(0, 1e-12));
}

TEST_CASE("directions integrate the cosine as finely as they are") {
  CHECK(cosine_error(4) == relative(0.0098, 0.1));
  CHECK(cosine_error(8) == relative(0.0024, 0.1));
  CHECK(cosine_error(16) == relative(0.00058, 0.1));
  CHECK(cosine_error(32) == relative(0.00014, 0.1));
}

TEST_CASE("solid angles are the integrals of hat functions") {
  const vlf::DirectionGrid grid(3, 3);
  constexpr int count = 40000;
  std::vector<double> integrals(grid.directions(), 0);
  for (int i = 0; i < count; ++i) {  // a Fibonacci lattice
    const double z = 1 - (2 * i + 1.) / count, angle = 2 * pi * i * 0.6180339887498949, r = std::sqrt(1 - z * z);
    for (const auto& [direction, hat] : hats_at(grid, {r * std::cos(angle), r * std::sin(angle), z}))
      integrals[direction] += 4 * pi / count * hat;
  }
  for (uint32_t d = 0; d < grid.directions(); ++d) CHECK(integrals[d] == relative(grid.solid_angle(d), 0.005));
}

// Over a triangle of area A the products of barycentric coordinates have the integrals A/3 (one), A/6 (its square),
// A/10 (its cube) and A/12 (two of them). With the density h/∫h the mean of h is then 1/2, that of h² 3/10, and that
// of a neighbour's hat function, which shares two of six triangles, 1/12; at the octahedron's corners two of four: 1/8.
// Uniform over the triangles instead, as of the paper's directions, they would be 1/3, 1/6 and 1/9 or 1/6.
TEST_CASE("directions about one of the grid have the density of its hat function") {
  constexpr uint32_t count = 4096;
  for (const uint32_t n : {2u, 5u}) {
    CAPTURE(n);
    const vlf::DirectionGrid grid(n, 5);
    for (uint32_t line = 0; line < grid.lines(); ++line) {
      CAPTURE(line);
      std::map<uint32_t, double> means;
      double squares = 0;
      for (const glm::dvec3& direction : grid.directions_about(line, count, 7)) {
        const std::map<uint32_t, double> hats = hats_at(grid, direction);
        const auto own = hats.find(2 * line);
        REQUIRE(own != hats.end());
        squares += own->second * own->second / count;
        for (const auto& [other, hat] : hats) means[other] += hat / count;
      }
      const bool corner = grid.solid_angle(2 * line) < 0.9 * pi / (n * n);
      REQUIRE(means.size() == (corner ? 5 : 7));
      CHECK(squares == within(0.3, 0.005));
      for (const auto& [other, mean] : means)
        CHECK(mean == within(other == 2 * line ? 0.5 : corner ? 1. / 8 : 1. / 12, 0.005));
    }
  }
}

TEST_CASE("a mirror takes the cells that its area and outline predict") {
  const SceneMaterial wall = test::emitter(1);
  for (const int tile : {4, 8, 16}) {
    CAPTURE(tile);
    vlf::Parameters parameters;
    parameters.dir_n = 8;
    parameters.cells = 128;
    parameters.texels = 2048;
    parameters.tile = tile;
    const test::FieldRig rig(test::unit_box({{1, test::mirror()}, {0, wall}, {2, wall}, {3, wall}}), parameters);
    const FieldInfo& info = rig.field().maps().info();
    // Tiles reach a cell farther on each side; two directions, one of which sees the front.
    const double c = static_cast<double>(info.cell), grown = (1 + 2 * c) * (1 + 2 * c);
    const double expected = vlf::expected_cells(grown, 4 * (1 + 2 * c), c, static_cast<uint32_t>(tile)) * info.lines;
    CHECK(rig.field().maps().cells() == relative(expected, 0.05));
  }
}

TEST_CASE("patches: a sphere falls into caps, a box into its faces, weak coats have none") {
  Scene scene = load_scene("builtin:spheres");
  vlf::Parameters parameters;
  parameters.dir_n = 4;
  parameters.cells = 32;
  parameters.texels = 8192;
  const test::FieldRig rig(std::move(scene), parameters);
  const vlf::Patches& patches = rig.surfaces().patches;
  CHECK(patches.facets.size() >= 12);
  uint32_t tiled = 0;
  for (const uint32_t facet : patches.side_facet) tiled += facet != LUCARIUM_NONE;
  CHECK(tiled > 0);
  CHECK(tiled < patches.side_facet.size() / 2);
  for (const FieldFacet& facet : patches.facets) CHECK(facet.count > 0);
}
