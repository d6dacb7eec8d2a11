// SPDX-License-Identifier: Apache-2.0
// Light gathered in scenes with closed forms.
#include <doctest/doctest.h>

#include "lucarium/base/numbers.h"
#include "synthetic_forest.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using test::dvec3;

namespace {

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
  struct Case {
    const char* sample;
    float splat_radius;
    double max_holes;
  };
  for (const Case& c : {Case{"1", 1.35f, 0.005}, Case{"1", 1.6f, 0.001}, Case{"0", 1.35f, 0.005}}) {
    CAPTURE(c.splat_radius);
    MicroSettings settings = test::default_settings();
    settings.splat_radius = c.splat_radius;
    const auto result = test::gather(forest, buffers, points_on_cube(count), settings,
                                     test::gather_program({{"MICRO_SAMPLE_SPLAT", c.sample}}));
    for (const float4& e : result.irradiance) CHECK(std::abs(e.x / pi - 1) < 0.01);
    CHECK(result.total().holes < c.max_holes * 576 * count);
    MESSAGE("empty " << mean_empty(result));
    CHECK(mean_empty(result) < 0.0005);
  }
}

namespace {

/// Mean E / pi over points and frames.
double mean_over_frames(const test::SyntheticForest& forest, const std::vector<test::GatherPoint>& points, int frames,
                        const test::Defines& defines = {}) {
  const auto buffers = forest.upload();
  test::GatherRun run(forest, buffers, points, test::gather_program(defines));
  double sum = 0;
  for (int frame = 0; frame < frames; ++frame) {
    run.run(test::default_settings(static_cast<uint32_t>(frame)));
    sum += run.result().mean_irradiance() / pi;
  }
  return sum / frames;
}

}  // namespace

TEST_CASE("a floor under a parallel disc gets R^2 / (R^2 + h^2)") {
  // Gathers below the centre of discs of radius 1, two heights; the floor itself gives off nothing.
  for (const double height : {0.5, 1.0, 2.0}) {
    CAPTURE(height);
    test::SyntheticForest forest;
    auto points = test::disc(1 << 13, dvec3(0, 0, height), dvec3(0, 0, -1), 1, dvec3(1));
    const auto floor = test::disc(1 << 13, dvec3(0), dvec3(0, 0, 1), 1, dvec3(0));
    points.insert(points.end(), floor.begin(), floor.end());
    forest.add(points, 2 * pi);
    for (const char* fill : {"1", "0"}) {
      const double light = mean_over_frames(forest, {{dvec3(0), dvec3(0, 0, 1)}}, 16, {{"MICRO_HOLE_FILL", fill}});
      MESSAGE("height " << height << " fill " << std::string(fill) << " ratio " << light * (1 + height * height));
      CHECK(std::abs(light * (1 + height * height) - 1) < 0.02);
    }
  }
}

TEST_CASE("discs that overlap share their plane: light does not move towards one of its sides") {
  // From below its middle the two halves of a ceiling, one shining at a time, give the same; as splats of coarse and
  // fine micro-buffers, and as few discs that are cast.
  struct Case {
    int rows;
    uint32_t edge;
  };
  for (const Case& c : {Case{128, 8}, Case{128, 24}, Case{16, 24}}) {
    for (const int axis : {0, 1}) {
      CAPTURE(c.rows);
      CAPTURE(axis);
      double light[2];
      for (const int side : {0, 1}) {
        std::vector<test::SurfacePointLight> points;
        for (int i = 0; i < c.rows * c.rows; ++i) {
          const dvec3 p(4 * (i % c.rows + 0.5) / c.rows - 2, 4 * (i / c.rows + 0.5) / c.rows - 2, 1);
          points.push_back({p, dvec3(0, 0, -1), dvec3((p[axis] > 0) == (side == 1) ? 1 : 0)});
        }
        test::SyntheticForest forest;
        forest.add(points, 16);
        const std::vector<test::GatherPoint> middle(
            16, test::GatherPoint{dvec3(0), dvec3(0, 0, 1), dvec3(0, 0, 1), 0.5, c.edge});
        light[side] = mean_over_frames(forest, middle, 64);
      }
      MESSAGE("one half over the other " << light[1] / light[0]);
      CHECK(light[1] == test::relative(light[0], 0.02));
    }
  }
}

TEST_CASE("in a half-lit sphere every point gets the mean; the nearest-node splat favours the near half") {
  test::SyntheticForest forest;
  forest.add(test::sphere_inside(1 << 15, 1, [](const dvec3& p) { return dvec3(p.z > 0 ? 2.5 : 0.5); }), 4 * pi);
  std::vector<test::GatherPoint> bright, dark;
  for (int i = 0; i < 60; ++i) {
    const double z = 0.15 + 0.8 * (i + 0.5) / 60, s = std::sqrt(1 - z * z), phi = test::golden_angle * i;
    const dvec3 p(s * std::cos(phi), s * std::sin(phi), z);
    bright.push_back({p, -p});
    dark.push_back({-p, p});
  }
  const double sample_bright = mean_over_frames(forest, bright, 8), sample_dark = mean_over_frames(forest, dark, 8);
  const test::Defines paper = {{"MICRO_SAMPLE_SPLAT", "0"}, {"MICRO_CONSERVATIVE_CUT", "0"}, {"MICRO_HOLE_FILL", "0"}};
  const double nearest_bright = mean_over_frames(forest, bright, 8, paper);
  MESSAGE("sample " << sample_bright / 1.5 << " " << sample_dark / 1.5 << " nearest " << nearest_bright / 1.5);
  CHECK(std::abs(sample_bright / 1.5 - 1) < 0.03);
  CHECK(std::abs(sample_dark / 1.5 - 1) < 0.03);
  CHECK(nearest_bright / 1.5 > 1.05);
  CHECK(nearest_bright / 1.5 < 1.09);
}

TEST_CASE("gathers and frames are jittered apart: their mean over n of either errs by about 1 / sqrt(n)") {
  // Many gathers at one point of a half-lit room, whose nodes are few and sharply bounded.
  test::SyntheticForest forest;
  forest.add(test::cube_inside(1 << 12, 1, [](const dvec3& p) { return dvec3(p.x > 0.13 ? 2 : 0); }), 24);
  const auto buffers = forest.upload();
  const std::vector<test::GatherPoint> points(64, {dvec3(0.1, 0.2, -1), dvec3(0, 0, 1)});
  test::GatherRun run(forest, buffers, points, test::gather_program());
  constexpr int frames = 16;
  std::vector<double> frame_means(frames), point_means(points.size());
  double mean = 0, squares = 0;
  const double count = frames * static_cast<double>(points.size());
  for (int frame = 0; frame < frames; ++frame) {
    run.run(test::default_settings(static_cast<uint32_t>(frame)));
    const std::vector<float4> irradiance = run.result().irradiance;
    for (size_t i = 0; i < points.size(); ++i) {
      const double e = double{irradiance[i].x};
      mean += e / count, squares += e * e / count;
      frame_means[frame] += e / static_cast<double>(points.size()), point_means[i] += e / frames;
    }
  }
  const double variance = squares - mean * mean;
  const auto variance_of = [&](const std::vector<double>& means) {
    double sum = 0;
    for (const double m : means) sum += (m - mean) * (m - mean) / static_cast<double>(means.size());
    return sum;
  };
  MESSAGE("deviation " << std::sqrt(variance) / mean << ", over points "
                       << variance_of(frame_means) * static_cast<double>(points.size()) / variance << ", over frames "
                       << variance_of(point_means) * frames / variance);
  CHECK(variance > 0);
  CHECK(variance_of(frame_means) * static_cast<double>(points.size()) < 4 * variance);
  CHECK(variance_of(point_means) * frames < 2 * variance);
}

TEST_CASE("light behind a thin wall does not leak") {
  // A wall without thickness, dark below and lit on its back, which is a tree of its own, under a lit ceiling.
  test::SyntheticForest forest;
  const auto lit = [](const dvec3&) { return dvec3(1); };
  const auto dark = [](const dvec3&) { return dvec3(0); };
  auto wall = test::rectangle(3 << 13, dvec3(0, 0, 1), dvec3(0, 1.2, 0), dvec3(1.2, 0, 0), dark);
  const auto ceiling = test::rectangle(1 << 13, dvec3(0, 0, 1.3), dvec3(0, 1, 0), dvec3(1, 0, 0), lit);
  wall.insert(wall.end(), ceiling.begin(), ceiling.end());
  auto back = test::rectangle(1 << 15, dvec3(0, 0, 1), dvec3(1.2, 0, 0), dvec3(0, 1.2, 0), lit);
  for (auto& p : wall) p.flags = MICRO_NODE_CULLABLE;
  for (auto& p : back) p.flags = MICRO_NODE_CULLABLE;
  forest.add(wall, 9.76);
  forest.add(back, 5.76);
  std::vector<test::GatherPoint> below;
  for (int i = 0; i < 64; ++i) below.push_back({dvec3(0.02 * i - 0.64, 0.3 - 0.01 * i, 0.014 * i), dvec3(0, 0, 1)});
  CHECK(mean_over_frames(forest, below, 8) < 0.005);
}

TEST_CASE("two trees, one turned, give what one gives") {
  test::SyntheticForest one, two;
  auto room = test::cube_inside(3 << 13, 1, [](const dvec3& p) { return dvec3(1 + 0.5 * p.z); });
  auto ball = test::sphere_inside(1 << 13, 0.3, [](const dvec3& p) { return dvec3(p.x > 0 ? 2 : 0); });
  for (auto& p : ball) {
    p.position += dvec3(0.1, -0.2, 0.1);
    p.normal = -p.normal;
  }
  auto all = room;
  all.insert(all.end(), ball.begin(), ball.end());
  one.add(all, 24 + 4 * pi * 0.09);
  room.resize(1 << 14);
  room = test::cube_inside(1 << 15, 1, [](const dvec3& p) { return dvec3(1 + 0.5 * p.z); });
  two.add(room, 24);
  const double c = std::cos(0.7), s = std::sin(0.7);
  two.add(ball, 4 * pi * 0.09, test::dmat3(c, s, 0, -s, c, 0, 0, 0, 1));
  const auto points = points_on_cube(60);
  const double a = mean_over_frames(one, points, 8), b = mean_over_frames(two, points, 8);
  MESSAGE(a << " " << b);
  CHECK(std::abs(a / b - 1) < 0.005);
}

TEST_CASE("a glossy lobe in a closed room of radiance 1 reflects its albedo, by every warp") {
  test::SyntheticForest forest;
  forest.add(test::cube_inside(1 << 15, 1, [](const dvec3&) { return dvec3(1); }), 24);
  const auto buffers = forest.upload();
  auto points = points_on_cube(30);
  for (auto& p : points) {
    p.view = glm::normalize(p.normal + dvec3(0.4, 0.5, 0.6) * (dvec3(1) - p.normal * p.normal));
    p.alpha = 0.3;
    p.diffuse_edge = 12;
    p.specular_edge = 20;
  }
  // The integral of D G2 / (4 cos_v cos_l) cos_l and with Schlick's weight, cos_v as above; midpoints over (z,
  // azimuth).
  const auto albedo_for = [](const dvec3& view, double a2) {
    glm::dvec2 sum(0);
    const int rows = 600, columns = 600;
    for (int i = 0; i < rows; ++i)
      for (int j = 0; j < columns; ++j) {
        const double z = (i + 0.5) / rows, phi = 2 * pi * (j + 0.5) / columns, s = std::sqrt(1 - z * z);
        const dvec3 l(s * std::cos(phi), s * std::sin(phi), z), h = glm::normalize(view + l);
        const double t = h.z * h.z * (a2 - 1) + 1;
        const double f =
            a2 / (pi * t * t) * 0.5 /
            (l.z * std::sqrt(a2 + (1 - a2) * view.z * view.z) + view.z * std::sqrt(a2 + (1 - a2) * l.z * l.z));
        sum += f * l.z * glm::dvec2(1, std::pow(1 - glm::dot(view, h), 5));
      }
    return sum * (2 * pi / (double(rows) * columns));
  };
  for (const char* warp : {"0", "1", "2"}) {
    CAPTURE(warp[0]);
    const Program& program = test::gather_program({{"MICRO_WARP", warp}});
    const auto result = test::gather(forest, buffers, points, test::default_settings(), program);
    double ratio = 0, grazing = 0;
    for (size_t i = 0; i < points.size(); ++i) {
      const double cosine = glm::dot(points[i].normal, points[i].view);
      const auto expected = albedo_for(dvec3(std::sqrt(1 - cosine * cosine), 0, cosine), 0.3 * 0.3);
      ratio += result.specular[2 * i].x / expected.x / static_cast<double>(points.size());
      grazing += result.specular[2 * i + 1].x / expected.y / static_cast<double>(points.size());
      CHECK(std::abs(result.irradiance[i].x / pi - 1) < (warp[0] == '2' ? 0.08 : 0.01));
    }
    CHECK(std::abs(ratio - 1) < 0.03);
    CHECK(std::abs(grazing - 1) < 0.05);
  }
}
