// SPDX-License-Identifier: Apache-2.0
// Look-ups on the device: the three directions around one, and radiance between the cells of a subfield.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "device_fixture.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/shared/scene_types.h"
#include "tolerance.h"
#include "virtual_light_field/directions/direction_grid.h"

const lucarium::EmbeddedSources& test_virtual_light_field_kernels();
const lucarium::EmbeddedSources& virtual_light_field_kernels();

using namespace lucarium;
using test::within;

namespace {

Program lookup_program() {
  SourceLibrary library;
  library.add(virtual_light_field_kernels());
  library.add(test_virtual_light_field_kernels());
  return Program(*test::test_device(), library,
                 {"test_virtual_light_field/lookups", {"test_virtual_light_field/lookups.cl"}, {}});
}

FieldInfo grid_info(const vlf::DirectionGrid& grid) {
  const auto row = [&](int r) {
    return float4(static_cast<float>(grid.rotation()[0][r]), static_cast<float>(grid.rotation()[1][r]),
                  static_cast<float>(grid.rotation()[2][r]), 0);
  };
  FieldInfo info{};
  info.rotation0 = row(0);
  info.rotation1 = row(1);
  info.rotation2 = row(2);
  info.grid = grid.n();
  info.lines = grid.lines();
  return info;
}

}  // namespace

TEST_CASE("look-ups of directions: weights sum to 1, nodes find themselves, others lie between their three") {
  constexpr uint32_t random_count = 20000;
  std::mt19937 random(5);
  std::normal_distribution<double> gauss;
  for (const uint32_t n : {3u, 16u}) {
    CAPTURE(n);
    const vlf::DirectionGrid grid(n, 11);
    std::vector<float4> directions;
    for (uint32_t d = 0; d < grid.directions(); ++d) directions.emplace_back(glm::vec3(grid.direction(d)), 0.f);
    for (uint32_t i = 0; i < random_count; ++i)
      directions.emplace_back(glm::vec3(glm::normalize(glm::dvec3(gauss(random), gauss(random), gauss(random)))), 0.f);
    const size_t count = directions.size();
    const auto device_nodes = test::test_buffer(grid.nodes());
    const auto device_directions = test::test_buffer(directions);
    const auto device_found = test::test_buffer<uint32_t>(3 * count);
    const auto device_weights = test::test_buffer<float>(3 * count);
    test::run_kernel(lookup_program(), "look_up_directions", count, 64, [&](PassBuilder& pass) {
      pass.arg("count", static_cast<uint32_t>(count)).arg("info", grid_info(grid)).arg("nodes", device_nodes);
      pass.arg("directions", device_directions).arg("found", device_found).arg("weights", device_weights);
    });
    const std::vector<uint32_t> found = device_found.download();
    const std::vector<float> weights = device_weights.download();
    double worst_sum = 0, worst_node = 0, worst_other = 0, least = 1;
    for (size_t i = 0; i < count; ++i) {
      glm::dvec3 mixed(0);
      double sum = 0;
      for (size_t q = 0; q < 3; ++q) {
        const auto weight = static_cast<double>(weights[3 * i + q]);
        sum += weight;
        least = std::min(least, weight);
        mixed += weight * grid.direction(found[3 * i + q]);
      }
      worst_sum = std::max(worst_sum, std::abs(sum - 1));
      const double off = glm::length(glm::normalize(mixed) - glm::dvec3(directions[i].xyz()));
      (i < grid.directions() ? worst_node : worst_other) =
          std::max(i < grid.directions() ? worst_node : worst_other, off);
    }
    CHECK(worst_sum < 1e-6);
    CHECK(least > -1e-6);
    CHECK(worst_node < 2e-3);  // single precision at the grid's folds
    // Farthest off beside a corner of the octahedron, where a chord stands for a quarter of a circle of radius
    // sqrt(2) / n: (1 - cos 45 degrees) sqrt(2) / n = 0.234 spacings; the curvature of the sphere adds its square.
    CHECK(worst_other < 0.235 * grid.spacing() + 0.2 * grid.spacing() * grid.spacing());
  }
}

TEST_CASE("look-ups of cells interpolate between their centres, and leave out what is not there") {
  // A map of 3 x 2 tiles of 4 x 4 cells that begins at cell (8, 4); the tile at its upper right is absent.
  const std::vector<FieldMap> maps = {{0, 8u | 4u << 16, 3u | 2u << 12 | 4u << 24}};
  std::vector<uint32_t> tile_cells, coordinates;
  for (uint32_t tile = 0; tile < 6; ++tile) {
    tile_cells.push_back(tile == 2 ? LUCARIUM_NONE : static_cast<uint32_t>(coordinates.size() / 2));
    for (uint32_t k = 0; k < 16 && tile != 2; ++k) {
      coordinates.push_back(8 + tile % 3 * 4 + k % 4);
      coordinates.push_back(4 + tile / 3 * 4 + k / 4);
    }
  }
  const auto cell_count = static_cast<uint32_t>(coordinates.size() / 2);
  const std::vector<float2> points = {{10, 7},   {12, 8},     {13.25f, 9.5f}, {8.5f, 4.5f},
                                      {8.1f, 6}, {16.25f, 6}, {18, 5},        {3, 3}};
  const auto device_coordinates = test::test_buffer(coordinates);
  const auto cells = test::test_buffer<uint32_t>(cell_count);
  const auto device_maps = test::test_buffer(maps);
  const auto device_tiles = test::test_buffer(tile_cells);
  const auto device_points = test::test_buffer(points);
  const auto device_found = test::test_buffer<float4>(points.size());
  test::run_kernel(lookup_program(), "fill_cells", cell_count, 64, [&](PassBuilder& pass) {
    pass.arg("count", cell_count).arg("coordinates", device_coordinates).arg("cells", cells);
  });
  test::run_kernel(lookup_program(), "look_up_cells", points.size(), 64, [&](PassBuilder& pass) {
    pass.arg("count", static_cast<uint32_t>(points.size())).arg("maps", device_maps).arg("tile_cells", device_tiles);
    pass.arg("cells", cells).arg("points", device_points).arg("found", device_found);
  });
  const std::vector<float4> found = device_found.download();
  for (size_t i = 0; i < 4; ++i) {
    CAPTURE(i);
    CHECK(found[i].x == within(static_cast<double>(points[i].x) - 0.5, 1e-4));
    CHECK(found[i].y == within(static_cast<double>(points[i].y) - 0.5, 1e-4));
    CHECK(found[i].w == within(1, 1e-5));
  }
  // At the border the outermost cell goes on; beside the absent tile likewise; beyond there is nothing.
  CHECK(found[4].x == within(8, 1e-4));
  CHECK(found[4].w == within(0.6, 1e-4));
  CHECK(found[5].x == within(15, 1e-4));
  CHECK(found[5].w == within(0.25, 1e-4));
  CHECK(found[6].w == 0);
  CHECK(found[7].w == 0);
}
