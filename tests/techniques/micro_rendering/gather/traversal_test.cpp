// SPDX-License-Identifier: Apache-2.0
// The walk over vectors of nodes does what the walk in preorder does, one node after the other.
#include <doctest/doctest.h>

#include <cstring>

#include "synthetic_forest.h"

using namespace lucarium;
using test::Defines;
using test::dvec3;

namespace {

/// A room with a ball, whose points are two-sided twins, and a black disc: all rules of the cut apply.
test::SyntheticForest make_scene() {
  test::SyntheticForest forest;
  auto points = test::cube_inside((1 << 14) - 2000, 1, [](const dvec3& p) { return dvec3(1 + p.z, 1, 1 - p.x); });
  auto ball = test::sphere_inside(500, 0.4, [](const dvec3&) { return dvec3(0.5); });
  for (auto& p : ball) p.flags = MICRO_NODE_CULLABLE;
  points.insert(points.end(), ball.begin(), ball.end());
  for (auto& p : ball) p.normal = -p.normal;
  points.insert(points.end(), ball.begin(), ball.end());
  const auto plate = test::disc(1000, dvec3(0.3, 0.2, 0.6), glm::normalize(dvec3(1, 2, 3)), 0.3, dvec3(2));
  points.insert(points.end(), plate.begin(), plate.end());
  forest.add(points, 24 * 16384. / 14384);
  return forest;
}

std::vector<test::GatherPoint> make_points() {
  std::vector<test::GatherPoint> points;
  for (int i = 0; i < 40; ++i) {
    const double x = std::fmod(0.3 + 0.618 * i, 1.8) - 0.9, y = std::fmod(0.1 + 0.7548 * i, 1.8) - 0.9;
    const dvec3 view = glm::normalize(dvec3(0.2 - x, 0.1 - y, 0.8));
    points.push_back({dvec3(x, y, -1), dvec3(0, 0, 1), view, 0.05 + 0.02 * i, 16, 18});
  }
  return points;
}

}  // namespace

TEST_CASE("vectors of any width give bit for bit what single nodes in preorder give") {
  const test::SyntheticForest forest = make_scene();
  const auto buffers = forest.upload();
  const auto points = make_points();
  const std::vector<Defines> all_rules = {{},
                                          {{"MICRO_SAMPLE_SPLAT", "0"}, {"MICRO_CONSERVATIVE_CUT", "0"}},
                                          {{"MICRO_WARP", "1"}},
                                          {{"MICRO_RAYCAST", "0"}, {"MICRO_DEPTH_BITS", "8"}}};
  const std::vector<Defines> widths = {
      {{"MICRO_LANES", "4"}}, {{"MICRO_LANES", "8"}}, {{"MICRO_LANES", "8"}, {"MICRO_PORTABLE", "1"}}};
  for (const Defines& rules : all_rules) {
    const auto run = [&](Defines defines) {
      defines.insert(rules.begin(), rules.end());
      return test::gather(forest, buffers, points, test::default_settings(), test::gather_program(defines));
    };
    const auto one = run({{"MICRO_LANES", "1"}});
    CHECK(one.total().visits > 40 * 2000);
    for (const Defines& width : widths) {
      const auto many = run(width);
      const size_t bytes = points.size() * sizeof(float4);
      CHECK(std::memcmp(one.irradiance.data(), many.irradiance.data(), bytes) == 0);
      CHECK(std::memcmp(one.specular.data(), many.specular.data(), 2 * bytes) == 0);
      for (size_t i = 0; i < points.size(); ++i) {
        CHECK(one.statistics[i].visits == many.statistics[i].visits);
        CHECK(one.statistics[i].splats == many.statistics[i].splats);
        CHECK(one.statistics[i].listed == many.statistics[i].listed);
        CHECK(one.statistics[i].levels == many.statistics[i].levels);
        CHECK(one.statistics[i].holes == many.statistics[i].holes);
        CHECK(one.statistics[i].disc_tests == many.statistics[i].disc_tests);
      }
    }
  }
}

TEST_CASE("the walk visits what a recursion visits") {
  // kappa so small that everything in sight is refined: a tree of n leaves that are all seen has 2 n - 1 nodes.
  test::SyntheticForest forest;
  forest.add(test::disc(1 << 10, dvec3(0, 0, 3), dvec3(0, 0, -1), 1, dvec3(1)), 3.14159);
  const auto buffers = forest.upload();
  MicroSettings settings = test::default_settings();
  settings.kappa = 1e-6f;
  const Program& program = test::gather_program();
  const auto all = test::gather(forest, buffers, {{dvec3(0), dvec3(0, 0, 1)}}, settings, program);
  CHECK(all.statistics[0].visits == 2047);
  CHECK(all.statistics[0].listed == 1024);
  CHECK(all.statistics[0].splats == 0);
  CHECK(all.statistics[0].flushes >= 1);
  // Turned away, nothing but the root is looked at.
  const auto none = test::gather(forest, buffers, {{dvec3(0), dvec3(0, 0, -1)}}, settings, program);
  CHECK(none.statistics[0].visits == 1);
}
