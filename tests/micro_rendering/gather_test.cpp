// SPDX-License-Identifier: Apache-2.0
// Light gathered in scenes with closed forms.
#include <doctest/doctest.h>

#include "synthetic_forest.h"
#include "test_support.h"

using namespace lucarium;
using test::dvec3;

namespace {

constexpr double pi = std::numbers::pi;

const Program& gather_program(const std::map<std::string, std::string>& defines = {}) {
  static std::map<std::map<std::string, std::string>, Program> programs;
  auto [at, added] = programs.try_emplace(defines);
  if (added) at->second = test::micro_program("micro_rendering/micro_gather.cl", defines);
  return at->second;
}

/// Points on the walls of the cube [-1, 1]^3 and their normals.
std::vector<test::GatherPoint> points_on_cube(int count) {
  std::vector<test::GatherPoint> points;
  for (int i = 0; i < count; ++i) {
    dvec3 p(std::fmod(0.2 + 0.618 * i, 1.8) - 0.9, std::fmod(0.7 + 0.7548 * i, 1.8) - 0.9, 0), n(0);
    const int axis = i % 3;
    std::swap(p.z, p[axis]);
    n[axis] = i % 2 ? 1 : -1;
    p[axis] = -n[axis];
    points.push_back({p, n, n});
  }
  return points;
}

/// Share of all pixels that stay empty after holes were filled.
double mean_empty(const test::GatherResult& result) {
  double sum = 0;
  for (const float4& e : result.irradiance) sum += e.w;
  return sum / static_cast<double>(result.irradiance.size());
}

}  // namespace

TEST_CASE("a closed room of radiance 1 reflects all of it, and its micro-buffers have no holes") {
  test::SyntheticForest forest;
  forest.add(test::cube_inside(1 << 14, 1, [](const dvec3&) { return dvec3(1); }), 24);
  const auto buffers = forest.upload();
  const int count = 150;
  // Discs of the nodes' areas, those of the default 1.1 times as large, leave gaps that only the filling closes.
  struct Case {
    const char* sample;
    float splat_radius;
    double most_holes;
  };
  for (const Case& c : {Case{"1", 1.1f, 0.02}, Case{"1", 1.3f, 0.005}, Case{"0", 1.1f, 0.005}}) {
    CAPTURE(c.splat_radius);
    MicroSettings settings = test::default_settings();
    settings.splat_radius = c.splat_radius;
    const auto result =
        test::gather(forest, buffers, points_on_cube(count), settings, gather_program({{"MICRO_SAMPLE_SPLAT", c.sample}}));
    for (const float4& e : result.irradiance) CHECK(std::abs(e.x / pi - 1) < 0.01);
    CHECK(result.total().holes < c.most_holes * 576 * count);
    CHECK(mean_empty(result) < 0.001);
  }
}
