// SPDX-License-Identifier: Apache-2.0
// Directions of bundles: lines, uniform over half the sphere whatever the sequence, guided ones by their own
// density.
#include "lucarium/services/bundles/direction_sequence.h"

#include <doctest/doctest.h>

#include <cmath>
#include <set>

#include "chi2.h"
#include "lucarium/base/numbers.h"
#include "tolerance.h"

using namespace lucarium;

namespace {

/// Counts of lines over cells of equal solid angle of the half sphere: z in `rows` bands, azimuth in 2 · rows.
std::vector<uint64_t> count_cells(const DirectionSequence& sequence, uint64_t first, uint64_t count, int rows) {
  std::vector<uint64_t> cells(size_t(2 * rows) * rows, 0);
  for (uint64_t i = first; i < first + count; ++i) {
    glm::vec3 d = sequence.at(i).direction;
    if (std::abs(glm::length(d) - 1) > 1e-5f) FAIL("not unit");
    if (d.z < 0) d = -d;
    const int row = std::min(int((1 - d.z) * static_cast<float>(rows)), rows - 1);
    const int column = std::min(int((std::atan2(d.y, d.x) / (2 * pi) + 0.5) * 2 * rows), 2 * rows - 1);
    ++cells[size_t(row) * 2 * rows + column];
  }
  return cells;
}

Environment spotted_environment() {
  Environment environment;
  environment.width = 16, environment.height = 8;
  environment.radiance.assign(128, glm::vec3(0.2f));
  environment.radiance[37] = glm::vec3(20, 10, 5);
  environment.radiance[100] = glm::vec3(0);
  environment.environment_from_world = glm::mat3(0, 0, 1, 1, 0, 0, 0, 1, 0);
  return environment;
}

}  // namespace

TEST_CASE("the lines of every sequence are uniform, and W is 2 pi") {
  for (const DirectionOrder kind :
       {DirectionOrder::iid, DirectionOrder::blocks, DirectionOrder::halton, DirectionOrder::hammersley}) {
    CAPTURE(static_cast<int>(kind));
    DirectionOptions options;
    options.order = kind;
    options.total = 8192;
    const DirectionSequence sequence(options, 3);
    const std::vector<uint64_t> cells = count_cells(sequence, 0, 8192, 8);
    const test::Chi2Result result =
        test::chi2_test(cells, std::vector<double>(cells.size(), 8192.0 / static_cast<double>(cells.size())));
    if (kind == DirectionOrder::iid)
      CHECK(result.p > 1e-4);
    else
      CHECK(result.statistic < 0.5 * result.cells);  // stratified: far more even than independent ones
    CHECK(sequence.at(5).weight == test::relative(2 * pi));
  }
}

TEST_CASE("a block of 128 directions has one in each of 128 equal cells of its square") {
  DirectionOptions options;
  options.block = 128;
  const DirectionSequence sequence(options, 11);
  for (const uint64_t block : {0, 1, 7}) {
    std::set<std::pair<int, int>> cells;
    for (uint64_t i = 128 * block; i < 128 * (block + 1); ++i) {
      const glm::vec3 d = sequence.at(i).direction;
      double phi = std::atan2(d.y, d.x) / (2 * pi);
      if (phi < 0) phi += 1;
      cells.insert({int((1 - d.z) * 16), int(phi * 8)});
    }
    CHECK(cells.size() >= 126);  // all 128, except directions whose single precision falls into the next cell
  }
}

TEST_CASE("every beginning is even") {
  DirectionOptions options;
  const DirectionSequence sequence(options, 4);
  for (const int n : {32, 128, 512}) {  // one direction per cell of n
    const std::vector<uint64_t> cells = count_cells(sequence, 0, n, n == 32 ? 4 : n == 128 ? 8 : 16);
    CHECK(test::chi2_test(cells, std::vector<double>(cells.size(), 1.0)).statistic < 0.15 * n);
  }
}

TEST_CASE("successive directions of permuted blocks are independent enough for pairs") {
  // Pairs of successive lines must fill the product space: cosines of neighbours are uniform.
  DirectionOptions options;
  options.permuted = true;
  const DirectionSequence sequence(options, 5);
  std::vector<uint64_t> cells(16, 0);
  for (uint64_t i = 0; i + 1 < 20480; i += 2) {
    const float cosine = glm::dot(sequence.at(i).direction, sequence.at(i + 1).direction);
    ++cells[std::min(int(std::abs(cosine) * 16), 15)];
  }
  CHECK(test::chi2_test(cells, std::vector<double>(16, 10240.0 / 16)).p > 1e-4);
}

TEST_CASE("guided directions follow the density that W is made of") {
  const Environment environment = spotted_environment();
  DirectionOptions options;
  options.guiding = 0.6f;
  for (const DirectionOrder kind : {DirectionOrder::iid, DirectionOrder::blocks}) {
    options.order = kind;
    const DirectionSequence sequence(options, 9, make_environment_guide(&environment));
    const int rows = 12, count = 40960;
    const std::vector<uint64_t> cells = count_cells(sequence, 0, count, rows);
    std::vector<double> expected;  // by a fine grid per cell
    const int fine = 16;
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < 2 * rows; ++column) {
        double sum = 0;
        for (int k = 0; k < fine * fine; ++k) {
          const double z = 1 - (row + (k / fine + 0.5) / fine) / rows;
          const double phi = 2 * pi * ((column + (k % fine + 0.5) / fine) / (2 * rows) - 0.5);
          const double r = std::sqrt(1 - z * z);
          const glm::vec3 line(r * std::cos(phi), r * std::sin(phi), z);
          sum += sequence.density(line) + sequence.density(-line);
        }
        expected.push_back(count * sum / (fine * fine) * 2 * pi / (2.0 * rows * rows));
      }
    }
    double total = 0, weight = 0;
    for (const double e : expected) total += e;
    CHECK(total == test::relative(count, 0.01));
    for (double& e : expected) e *= count / total;
    const test::Chi2Result result = test::chi2_test(cells, expected);
    if (kind == DirectionOrder::iid) CHECK(result.p > 1e-6);
    // ∫ W q dω over the sphere is half of it: each line serves both ways.
    for (int i = 0; i < count; ++i) weight += sequence.at(i).weight;
    CHECK(weight / count == test::relative(2 * pi, 0.01));
  }
}
