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

struct FoundDirections {
  std::vector<uint32_t> found;  // three of each
  std::vector<float> weights;
};

FoundDirections look_up(const std::string& kernel, size_t items, const vlf::DirectionGrid& grid,
                        const std::vector<float4>& directions) {
  const size_t count = directions.size();
  const auto device_nodes = test::test_buffer(grid.nodes());
  const auto device_directions = test::test_buffer(directions);
  const auto device_found = test::test_buffer<uint32_t>(3 * count);
  const auto device_weights = test::test_buffer<float>(3 * count);
  test::run_kernel(lookup_program(), kernel, items, 64, [&](PassBuilder& pass) {
    pass.arg("count", static_cast<uint32_t>(count)).arg("info", grid_info(grid)).arg("nodes", device_nodes);
    pass.arg("directions", device_directions).arg("found", device_found).arg("weights", device_weights);
  });
  return {device_found.download(), device_weights.download()};
}

std::vector<float4> look_up(const std::string& kernel, size_t items, const FieldMap& map,
                            const std::vector<uint32_t>& tile_cells, const TypedBuffer<uint32_t>& cells,
                            const std::vector<float2>& points) {
  const auto device_maps = test::test_buffer(std::vector<FieldMap>{map});
  const auto device_tiles = test::test_buffer(tile_cells);
  const auto device_points = test::test_buffer(points);
  const auto device_found = test::test_buffer<float4>(points.size());
  test::run_kernel(lookup_program(), kernel, items, 64, [&](PassBuilder& pass) {
    pass.arg("count", static_cast<uint32_t>(points.size())).arg("maps", device_maps).arg("tile_cells", device_tiles);
    pass.arg("cells", cells).arg("points", device_points).arg("found", device_found);
  });
  return device_found.download();
}

}  // namespace

TEST_CASE("look-ups of eight directions at once find what those of one find") {
  std::mt19937 random(6);
  std::normal_distribution<double> gauss;
  const vlf::DirectionGrid grid(5, 12);
  std::vector<float4> directions;
  for (const double x : {-1., 0., 1.})  // of the grid's axes, too
    for (const double y : {-1., 0., 1.})
      for (const double z : {-1., 0., 1.})
        if (x != 0 || y != 0 || z != 0)
          directions.emplace_back(glm::vec3(glm::transpose(grid.rotation()) * glm::normalize(glm::dvec3(x, y, z))),
                                  0.f);
  while (directions.size() < 4000)
    directions.emplace_back(glm::vec3(glm::normalize(glm::dvec3(gauss(random), gauss(random), gauss(random)))), 0.f);
  const FoundDirections one = look_up("look_up_directions", directions.size(), grid, directions),
                        eight = look_up("look_up_directions_by_eight", directions.size() / 8, grid, directions);
  size_t elsewhere = 0;
  for (size_t i = 0; i < directions.size(); ++i) {
    glm::dvec3 mixed[2] = {glm::dvec3(0), glm::dvec3(0)};
    for (size_t q = 3 * i; q < 3 * i + 3; ++q) {
      mixed[0] += static_cast<double>(one.weights[q]) * grid.direction(one.found[q]);
      mixed[1] += static_cast<double>(eight.weights[q]) * grid.direction(eight.found[q]);
      elsewhere += one.found[q] != eight.found[q];
    }
    CHECK(glm::length(mixed[0] - mixed[1]) < 1e-5);
  }
  CHECK(elsewhere < 60);  // on borders of triangles
}

TEST_CASE("look-ups of eight points at once find the cells that those of one find") {
  // Tiles as below, and rows that begin at cells 9 and 11.
  const FieldMap tiles = {0, 8u | 4u << 16, 3u | 2u << 12 | 4u << 24}, rows = {0, 4u << 16, 1u | 2u << 12};
  const std::vector<uint32_t> tile_cells = {0, 16, LUCARIUM_NONE, 32, 48, 64},
                              row_cells = {0, 9u | 7u << 16, 7, 11u | 5u << 16};
  std::vector<uint32_t> coordinates;
  std::mt19937 random(7);
  for (int i = 0; i < 160; ++i) coordinates.push_back(static_cast<uint32_t>(random() % 200));
  const auto cells = test::test_buffer<uint32_t>(80);
  const auto device_coordinates = test::test_buffer(coordinates);
  test::run_kernel(lookup_program(), "fill_cells", 80, 64, [&](PassBuilder& pass) {
    pass.arg("count", 80u).arg("coordinates", device_coordinates).arg("cells", cells);
  });
  std::uniform_real_distribution<float> x(5, 23), y(2, 14);
  std::vector<float2> points;
  for (int i = 0; i < 4000; ++i) points.emplace_back(x(random), y(random));
  for (const bool of_rows : {false, true}) {
    CAPTURE(of_rows);
    const FieldMap& map = of_rows ? rows : tiles;
    const std::vector<uint32_t>& list = of_rows ? row_cells : tile_cells;
    const std::vector<float4> one = look_up("look_up_cells", points.size(), map, list, cells, points),
                              eight = look_up("look_up_cells_by_eight", points.size() / 8, map, list, cells, points);
    size_t known = 0;
    for (size_t i = 0; i < points.size(); ++i) {
      known += one[i].w > 0;
      CHECK(glm::length(one[i].xyz() - eight[i].xyz()) < 1e-3f);
      CHECK(std::abs(one[i].w - eight[i].w) < 1e-5f);
    }
    CHECK(known > 200);
    CHECK(known < points.size());
  }
}

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
    const auto [found, weights] = look_up("look_up_directions", count, grid, directions);
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
  const FieldMap map = {0, 8u | 4u << 16, 3u | 2u << 12 | 4u << 24};
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
  test::run_kernel(lookup_program(), "fill_cells", cell_count, 64, [&](PassBuilder& pass) {
    pass.arg("count", cell_count).arg("coordinates", device_coordinates).arg("cells", cells);
  });
  const std::vector<float4> found = look_up("look_up_cells", points.size(), map, tile_cells, cells, points);
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
