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

}  // namespace

TEST_CASE("a closed room of radiance 1 reflects all of it, and its micro-buffers have no holes") {
  test::SyntheticForest forest;
  forest.add(test::cube_inside(1 << 14, 1, [](const dvec3&) { return dvec3(1); }), 24);
  const auto buffers = forest.upload();
  const auto points = points_on_cube(150);
  const auto result = test::gather(forest, buffers, points, test::default_settings(), gather_program());
  const auto total = result.total();
  MESSAGE("E/pi " << result.mean_irradiance() / pi << " visits " << total.visits / 150 << " splats "
                  << total.splats / points.size() << " listed " << total.listed / points.size() << " discs "
                  << total.disc_tests / points.size() << " holes " << total.holes);
  for (const float4& e : result.irradiance) CHECK(std::abs(e.x / pi - 1) < 0.01);
  CHECK(total.holes < 0.005 * 576 * static_cast<double>(points.size()));
}

TEST_CASE("probe") {
  test::SyntheticForest forest;
  forest.add(test::cube_inside(1 << 14, 1, [](const dvec3&) { return dvec3(1); }), 24);
  const auto buffers = forest.upload();
  const auto points = points_on_cube(150);
  for (float cs : {1.0f, 1.1f, 1.3f, 1.5f, 1.7f})
    for (const char* sample : {"1", "0"}) {
      auto settings = test::default_settings();
      settings.splat_radius = cs;
      const auto r = test::gather(forest, buffers, points, settings, gather_program({{"MICRO_SAMPLE_SPLAT", sample}}));
      double empty = 0;
      for (auto& e : r.irradiance) empty += e.w;
      MESSAGE(cs << " sample " << sample << " holes " << r.total().holes / 576. / 150 << " E " << r.mean_irradiance() / pi << " empty " << empty / 150);
    }
}
