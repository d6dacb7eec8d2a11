// SPDX-License-Identifier: Apache-2.0
// What a gather leaves out: what faces away, what is below the horizon, its own surface. And what hides what.
#include <doctest/doctest.h>

#include "lucarium/base/numbers.h"
#include "synthetic_forest.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using test::dvec3;

namespace {

/// Mean E / pi and mean share of the hemisphere that stays empty, at one or several points over frames.
struct Gathered {
  double light = 0, empty = 0;
};
Gathered gathered(const test::SyntheticForest& forest, const std::vector<test::GatherPoint>& points, int frames,
                  const test::Defines& defines = {}) {
  const auto buffers = forest.upload();
  test::GatherRun run(forest, buffers, points, test::gather_program(defines));
  Gathered result;
  for (int frame = 0; frame < frames; ++frame) {
    run.run(test::default_settings(static_cast<uint32_t>(frame)));
    for (const float4& e : run.result().irradiance) {
      const double weight = 1. / (frames * static_cast<double>(points.size()));
      result.light += weight * double{e.x} / pi;
      result.empty += weight * double{e.w};
    }
  }
  return result;
}

std::vector<test::SurfacePointLight> with_flags(std::vector<test::SurfacePointLight> points, uint32_t flags) {
  for (test::SurfacePointLight& p : points) p.flags = flags;
  return points;
}

dvec3 one(const dvec3&) { return dvec3(1); }

}  // namespace

TEST_CASE("a ball of radiance 1 gives R^2 / d^2, whatever its back is: no node that faces the gather in part is lost") {
  for (const uint32_t flags : {0u, MICRO_NODE_CULLABLE}) {
    CAPTURE(flags);
    test::SyntheticForest forest;
    forest.add(with_flags(test::sphere_outside(1 << 14, 1, one), flags), 4 * pi);
    const double d = 1.5;
    const Gathered found = gathered(forest, {{dvec3(0, 0, -d), dvec3(0, 0, 1)}}, 16);
    MESSAGE("ratio " << found.light * d * d);
    CHECK(found.light * d * d == test::relative(1, 0.02));
  }
}

TEST_CASE("a wall that goes on below the horizon gives the light of its part above") {
  // The wall x = 1, |y| <= 2, -3 <= z <= 2 of radiance 1 seen from the origin, whose normal is z. Of each half its part
  // above gives (atan b - atan (b / r) / r) / 2, b = 2, r = sqrt(1 + c^2), c = 2 (in pi).
  test::SyntheticForest forest;
  forest.add(test::rectangle(1 << 14, dvec3(1, 0, -0.5), dvec3(0, 0, 2.5), dvec3(0, 2, 0), one), 20);
  const Gathered found = gathered(forest, {{dvec3(0), dvec3(0, 0, 1)}}, 32);
  const double r = std::sqrt(5), expected = (std::atan(2) - std::atan(2 / r) / r) / pi;
  MESSAGE("ratio " << found.light / expected);
  CHECK(found.light == test::relative(expected, 0.02));
}

TEST_CASE("what faces away is black, or nothing where it is transparent: no back shines") {
  // A disc overhead that faces up; as splats and, of few points, as discs that are cast, each farther than 4 of its
  // radii. It fills R^2 / (R^2 + h^2) of the hemisphere.
  const double radius = 5, height = 2.5, share = radius * radius / (radius * radius + height * height);
  for (const int count : {1 << 16, 1 << 12}) {
    CAPTURE(count);
    for (const uint32_t flags : {0u, MICRO_NODE_CULLABLE}) {
      CAPTURE(flags);
      test::SyntheticForest forest;
      forest.add(with_flags(test::disc(count, dvec3(0, 0, height), dvec3(0, 0, 1), radius, dvec3(1)), flags),
                 pi * radius * radius);
      const Gathered found = gathered(forest, {{dvec3(0), dvec3(0, 0, 1)}}, 4);
      CHECK(found.light == 0);
      CHECK(found.empty == test::within(flags ? 1 : 1 - share, 0.03));
    }
  }
}

TEST_CASE("a plane and a ball neither shine at themselves nor hide what is around them") {
  // Each in a sphere of radiance 1, itself of radiance 5.
  const auto bright = [](const dvec3&) { return dvec3(5); };
  const dvec3 up = glm::normalize(dvec3(0.3, -0.5, 0.8));
  test::SyntheticForest plane, ball;
  plane.add(test::disc(1 << 13, dvec3(0), up, 1, dvec3(5)), pi);
  ball.add(test::sphere_outside(1 << 13, 1, bright), 4 * pi);
  for (test::SyntheticForest* forest : {&plane, &ball}) forest->add(test::sphere_inside(1 << 14, 3, one), 36 * pi);
  std::vector<test::GatherPoint> on_plane, on_ball;
  const dvec3 t = glm::normalize(glm::cross(up, dvec3(1, 0, 0))), b = glm::cross(up, t);
  for (int i = 0; i < 64; ++i) {
    const double r = 0.9 * std::sqrt((i + 0.5) / 64), phi = test::golden_angle * i, z = 1 - (2 * i + 1) / 64.;
    const dvec3 n(std::sqrt(1 - z * z) * std::cos(phi), std::sqrt(1 - z * z) * std::sin(phi), z);
    on_plane.push_back({r * (std::cos(phi) * t + std::sin(phi) * b), up});
    on_ball.push_back({n, n});
  }
  // Its own leaves, however near, are nothing to cast rays at.
  test::SyntheticForest alone;
  alone.add(test::disc(1 << 13, dvec3(0), up, 1, dvec3(5)), pi);
  CHECK(
      test::gather(alone, alone.upload(), on_plane, test::default_settings(), test::gather_program()).total().listed ==
      0);
  for (const test::Defines& defines : {test::Defines{}, {{"MICRO_RAYCAST", "0"}}, {{"MICRO_SAMPLE_SPLAT", "0"}}}) {
    CAPTURE(defines.size());
    const double from_plane = gathered(plane, on_plane, 2, defines).light,
                 from_ball = gathered(ball, on_ball, 2, defines).light;
    MESSAGE((defines.empty() ? "default" : defines.begin()->first) << ": " << from_plane << ", " << from_ball);
    CHECK(from_plane == test::relative(1, 0.01));
    CHECK(from_ball == test::relative(1, 0.01));
  }
}

TEST_CASE("what stands before an uneven field hides the light behind it, and shows its own") {
  // From the bottom of a sphere, of which one side shines 2 and the other 1/4, part of the bright side lies behind a
  // disc of radiance 1/2. Cosine-distributed rays say what is left. (In a field of one radiance it would not matter
  // which part is hidden.)
  const dvec3 point(0, 0, -1), center(0.3, 0.1, 0);
  const double radius = 0.4, own = 0.5;
  const auto field = [](const dvec3& p) { return dvec3(p.x > -0.1 ? 2 : 0.25); };
  double expected = 0, open = 0;
  constexpr int cells = 512;
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const double r = std::sqrt((i + 0.5) / cells), phi = 2 * pi * (j + 0.5) / cells;
      const dvec3 w(r * std::cos(phi), r * std::sin(phi), std::sqrt(1 - r * r));
      const double behind = field(point + 2 * w.z * w).x;
      const bool hidden = glm::distance(point + w / w.z, center) < radius;
      expected += (hidden ? own : behind) / (cells * cells);
      open += behind / (cells * cells);
    }
  for (const int leaves : {1 << 14, 1 << 6}) {  // as splats, and as discs that are cast
    CAPTURE(leaves);
    test::SyntheticForest forest;
    forest.add(test::sphere_inside(1 << 15, 1, field), 4 * pi);
    forest.add(test::disc(leaves, center, dvec3(0, 0, -1), radius, dvec3(own)), pi * radius * radius);
    const Gathered found = gathered(forest, {{point, dvec3(0, 0, 1)}}, 64);
    MESSAGE("ratio " << found.light / expected << ", without the disc " << open / expected);
    CHECK(found.light == test::relative(expected, leaves > 64 ? 0.01 : 0.04));  // few discs reach beyond the rim
  }
  CHECK(open > 1.1 * expected);
}
