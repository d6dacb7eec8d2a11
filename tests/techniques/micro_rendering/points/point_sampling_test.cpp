// SPDX-License-Identifier: Apache-2.0
// Points on surfaces: shares of area, distances, determinism, and the order of the tree.
#include "micro_rendering/points/point_sampling.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/glm.hpp>
#include <random>

#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/stopwatch.h"
#include "micro_rendering/tree/tree_order.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::micro;

namespace {

/// A square of `cells`² squares of two triangles each, in the plane y = height.
void add_square(std::vector<SurfaceSide>& sides, float height, float size, int cells, bool upwards, uint32_t source) {
  const float step = size / static_cast<float>(cells);
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) {
      const glm::vec3 a(step * static_cast<float>(i), height, step * static_cast<float>(j)),
          b = a + glm::vec3(0, 0, step), c = a + glm::vec3(step, 0, step), d = a + glm::vec3(step, 0, 0);
      if (upwards) {
        sides.push_back({a, b, c, source});
        sides.push_back({a, c, d, source});
      } else {
        sides.push_back({a, c, b, source});
        sides.push_back({a, d, c, source});
      }
    }
  }
}

/// Distances in r0 = sqrt(A / n pi) from random places of the unit square to the nearest point, sorted.
std::vector<double> cover_radii(const std::vector<SampledPoint>& points, double area) {
  const double r0 = std::sqrt(area / (3.14159265358979 * static_cast<double>(points.size())));
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform;
  std::vector<double> radii;
  for (int k = 0; k < 4000; ++k) {
    // The border is left out: nothing lies beyond it.
    const glm::vec3 p(0.1f + 0.8f * uniform(random), 0, 0.1f + 0.8f * uniform(random));
    float nearest = INFINITY;
    for (const SampledPoint& q : points) nearest = std::min(nearest, glm::distance(p, q.position));
    radii.push_back(nearest / r0);
  }
  std::sort(radii.begin(), radii.end());
  return radii;
}

}  // namespace

TEST_CASE("points are shared out by area") {
  std::vector<SurfaceSide> sides;
  add_square(sides, 0, 1, 1, true, 1);      // area 1
  add_square(sides, 2, 0.5f, 8, true, 2);   // area 1/4, many triangles
  add_square(sides, 3, 0.25f, 1, true, 3);  // area 1/16
  const SampledSurface sampled = sample_surface(sides, 1 << 14, 1, 2);
  CHECK(sampled.area == test::relative(1.3125));
  double shares[4] = {};
  for (const SampledPoint& p : sampled.points) shares[p.source] += 1.0 / (1 << 14);
  // Strata that lie across two surfaces may give their points to either: at most two per round.
  CHECK(shares[1] == test::relative(1 / 1.3125, 0.002));
  CHECK(shares[2] == test::relative(0.25 / 1.3125, 0.005));
  CHECK(shares[3] == test::relative(0.0625 / 1.3125, 0.02));
}

TEST_CASE("points cover a plane as evenly as best candidates do") {
  std::vector<SurfaceSide> sides;
  add_square(sides, 0, 1, 4, true, 0);
  for (const uint32_t count : {1u << 11, 1u << 13}) {
    const std::vector<double> radii = cover_radii(sample_surface(sides, count, 3, 2).points, 1);
    const auto quantile = [&](double q) {
      return radii[static_cast<size_t>(q * static_cast<double>(radii.size() - 1))];
    };
    CHECK(quantile(0.5) == test::relative(0.73, 0.05));
    CHECK(quantile(0.99) < 1.6);
    CHECK(radii.back() < 2.3);
  }
}

TEST_CASE("the two sides of a sheet leave each other alone") {
  std::vector<SurfaceSide> sides;
  add_square(sides, 0, 1, 2, true, 0);
  add_square(sides, 0, 1, 2, false, 1);
  const SampledSurface sampled = sample_surface(sides, 1 << 12, 3, 2);
  std::vector<SampledPoint> upper;
  for (const SampledPoint& p : sampled.points) {
    CHECK(p.normal.y == test::relative(p.source == 0 ? 1 : -1));
    if (p.source == 0) upper.push_back(p);
  }
  CHECK(upper.size() == test::relative(1 << 11, 0.01));
  const std::vector<double> radii = cover_radii(upper, 1);
  CHECK(radii[static_cast<size_t>(0.99 * static_cast<double>(radii.size()))] < 1.7);
}

TEST_CASE("the number of threads changes nothing") {
  std::vector<SurfaceSide> sides;
  add_square(sides, 0, 1, 8, true, 0);
  const SampledSurface one = sample_surface(sides, 1 << 13, 9, 1), three = sample_surface(sides, 1 << 13, 9, 3);
  CHECK(std::memcmp(one.points.data(), three.points.data(), one.points.size() * sizeof(SampledPoint)) == 0);
  CHECK(tree_order(one.points, 1) == tree_order(one.points, 3));
  const SampledSurface other = sample_surface(sides, 1 << 13, 10, 1);
  CHECK(std::memcmp(one.points.data(), other.points.data(), one.points.size() * sizeof(SampledPoint)) != 0);
}

TEST_CASE("points are where the test says that the surface is") {
  std::vector<SurfaceSide> sides;
  add_square(sides, 0, 1, 2, true, 0);
  for (SurfaceSide& side : sides) side.coverage = 0.5f;
  const auto half = [](const void*, uint32_t, glm::vec2 weights, float) { return weights.x + weights.y < 0.5f; };
  const SampledSurface sampled = sample_surface(sides, 1 << 10, 3, 1, half, nullptr);
  CHECK(sampled.area == test::relative(0.5));
  for (const SampledPoint& p : sampled.points) CHECK(p.weights.x + p.weights.y < 0.5f);
}

TEST_CASE("placing points reports progress, and ends when interrupted") {
  std::vector<SurfaceSide> sides;
  add_square(sides, 0, 1, 2, true, 0);
  uint32_t last = 0;
  sample_surface(sides, 1 << 12, 3, 2, nullptr, nullptr, [&](uint32_t placed) {
    CHECK(placed >= last);
    last = placed;
  });
  CHECK(last == 1 << 12);
  const auto interrupted = [](auto work) {
    set_interrupt_requested(true);
    bool thrown = false;
    try {
      work();
    } catch (const Error& error) {
      thrown = error.error_class() == ErrorClass::interrupted;
    }
    set_interrupt_requested(false);
    return thrown;
  };
  const SampledSurface sampled = sample_surface(sides, 64, 3, 1);
  CHECK(interrupted([&] { sample_surface(sides, 1 << 12, 3, 2); }));
  CHECK(interrupted([&] { tree_order(sampled.points, 1); }));
}

TEST_CASE("surfaces without area give points all the same") {
  const glm::vec3 p(1, 2, 3);
  const SampledSurface sampled = sample_surface({{p, p, p, 7}}, 64, 1, 1);
  CHECK(sampled.area == 0);
  for (const SampledPoint& q : sampled.points) CHECK((q.position == p && q.source == 7 && q.area == 0));
}

TEST_CASE("the tree's order splits at medians of the longest axis") {
  std::vector<SurfaceSide> sides;
  add_square(sides, 0, 1, 2, true, 0);
  add_square(sides, 3, 1, 2, true, 1);
  const SampledSurface sampled = sample_surface(sides, 1 << 10, 3, 1);
  const std::vector<uint32_t> order = tree_order(sampled.points, 2);
  std::vector<bool> seen(order.size());
  for (const uint32_t i : order) seen[i] = true;
  CHECK(std::count(seen.begin(), seen.end(), true) == 1 << 10);
  // Height is the longest axis at the root.
  for (size_t i = 0; i < order.size(); ++i) CHECK(sampled.points[order[i]].source == (i < order.size() / 2 ? 0 : 1));
}

TEST_CASE("the two sides of a sheet are parted at the top of the tree") {
  std::vector<SurfaceSide> sides;
  add_square(sides, 0, 1, 2, true, 0);
  add_square(sides, 0.01f, 1, 2, false, 1);
  const SampledSurface sampled = sample_surface(sides, 1 << 10, 3, 1);
  const std::vector<uint32_t> order = tree_order(sampled.points, 2);
  // The sides have the same area, but a few points more or less.
  size_t mixed = 0;
  for (size_t i = 0; i < order.size(); i += 8) {
    for (size_t k = 1; k < 8; ++k) mixed += sampled.points[order[i]].source != sampled.points[order[i + k]].source;
  }
  CHECK(mixed <= 8);
}

TEST_CASE("a million points take seconds") {
  if (!test::full_run()) return;
  std::vector<SurfaceSide> sides;
  add_square(sides, 0, 4, 100, true, 0);
  add_square(sides, 3, 4, 100, false, 1);
  const Stopwatch sampling;
  const SampledSurface sampled = sample_surface(sides, 1 << 20, 3, 2);
  const double sampling_seconds = sampling.seconds();
  const Stopwatch ordering;
  tree_order(sampled.points, 2);
  MESSAGE("sampling ", sampling_seconds, " s, tree ", ordering.seconds(), " s");
  CHECK(sampled.points.size() == 1 << 20);
}
