// SPDX-License-Identifier: Apache-2.0
// Bounces: furnaces whose every bounce is known, a room and a glossy box against path-traced values.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "bundle_rig.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::bundle;

namespace {

constexpr float kPi = 3.14159265f;

Scene diffuse_furnace(float albedo) {
  Scene scene;
  const int wall = add_lambert(scene, "wall", glm::vec3(albedo));
  return test::box_scene({wall, wall, wall, wall, wall, wall}, std::move(scene));
}

/// Where a line that leaves a point of the unit box's wall (2 axis + side) along d arrives.
std::pair<int, glm::dvec3> across(const glm::dvec3& p, int wall, glm::dvec3 d) {
  if ((d[wall / 2] > 0) != (wall % 2 == 0)) d = -d;
  int found = wall;
  double nearest = 1e30;
  for (int axis = 0; axis < 3; ++axis) {
    const double t = ((d[axis] > 0 ? 1.0 : 0.0) - p[axis]) / d[axis];
    if (t < nearest && (axis != wall / 2 || t > 0.5)) nearest = t, found = 2 * axis + (d[axis] > 0);
  }
  return {found, p + nearest * d};
}

constexpr int kSide = 4;  // texels of a wall's edge

int texel_at(int wall, const glm::dvec3& p) {
  const int axis = wall / 2;
  const auto cell = [](double x) { return std::clamp(static_cast<int>(x * kSide), 0, kSide - 1); };
  return (wall * kSide + cell(p[(axis + 1) % 3])) * kSide + cell(p[(axis + 2) % 3]);
}

/// The same deficit of a running mean by its recurrence along given directions: texels take what lines from `points`²
/// of their points meet, in proportion to their cosine. The first few directions decide much, and only the mean over
/// seeds is that of steps 1/i. The bundle image's pixels must be small against texels, or early directions miss some of
/// them.
double running_deficit(const DirectionSequence& sequence, double albedo, int count, int points) {
  constexpr int kTexels = 6 * kSide * kSide;
  std::vector<double> deficit(kTexels, 1.0), sum(kTexels, 0.0), weight(kTexels, 0.0);
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 d(sequence.at(i).direction);
    for (int wall = 0; wall < 6; ++wall) {
      const int axis = wall / 2, fine = kSide * points;
      for (int k = 0; k < fine * fine; ++k) {
        glm::dvec3 p;
        p[axis] = wall % 2;
        p[(axis + 1) % 3] = (k / fine + 0.5) / fine;
        p[(axis + 2) % 3] = (k % fine + 0.5) / fine;
        const auto [other, q] = across(p, wall, d);
        sum[texel_at(wall, p)] += std::abs(d[axis]) * albedo * deficit[texel_at(other, q)];
        weight[texel_at(wall, p)] += std::abs(d[axis]);
      }
    }
    for (int t = 0; t < kTexels; ++t) deficit[t] = sum[t] / weight[t];
  }
  double mean = 0;
  for (const double value : deficit) mean -= value / kTexels;
  return mean;
}

/// Relative deficit of indirect light in a box of emission 1 and albedo 0.8, after 2048 directions.
double furnace_deficit(Interleave interleave, bool balance, uint64_t seed = 1, float pixel_size = 0.7f) {
  Parameters parameters;
  parameters.batch = 1;
  parameters.directions = 2048;
  parameters.interleave = interleave;
  parameters.balance = balance;
  test::BundleRig rig(diffuse_furnace(0.8f), 96, pixel_size, {}, parameters);
  rig.set_direct(kPi);
  rig.solve(make_sequence(parameters, seed), 2048);
  return rig.mean(rig.indirect()) / 4 - 1;
}

}  // namespace

TEST_CASE("a furnace of albedo 0.8 fills as the recurrences say") {
  const double sd = furnace_deficit(Interleave::sd, false);
  CHECK(sd < 0);
  CHECK(std::abs(sd) < 0.002);
  CHECK(furnace_deficit(Interleave::fixed, false) == test::relative(-0.69, 0.015));
  CHECK(std::abs(furnace_deficit(Interleave::sd, true)) < 1e-4);  // the balance knows the answer at once
}

TEST_CASE("a running mean lacks 18.7 % of the furnace's light") {
  const auto predicted = [](uint64_t seed, int points) {
    return running_deficit(make_sequence(Parameters(), seed), 0.8, 2048, points);
  };
  const int seeds = test::full_run() ? 128 : 32;
  double mean = 0;
  for (int seed = 1; seed <= seeds; ++seed) mean += predicted(static_cast<uint64_t>(seed), 2) / seeds;
  MESSAGE("mean ", mean);
  CHECK(std::abs(mean + 0.187) < 0.003);
  for (const uint64_t seed : {1u, 2u}) {
    CAPTURE(seed);
    const double measured = furnace_deficit(Interleave::running, false, seed, 0.13f), expected = predicted(seed, 8);
    MESSAGE("measured ", measured, ", predicted ", expected);
    CHECK(std::abs(measured - expected) < 0.003);
  }
}

TEST_CASE("bounce after bounce: with a limit, and one by one") {
  for (const uint32_t bounces : {1u, 2u, 3u}) {
    Parameters parameters;
    Channels channels;
    channels.self_fed = false;
    channels.count = bounces;
    test::BundleRig rig(diffuse_furnace(0.5f), 384, 0.5f, channels, parameters);
    rig.set_direct(kPi);
    rig.solve(make_sequence(parameters, 1), 1024);
    double expected = 0;
    for (uint32_t k = 1; k <= bounces; ++k) expected += std::pow(0.5, k);
    CHECK(rig.mean(rig.indirect()) == test::relative(expected, 0.004));
  }
  Parameters parameters;
  parameters.interleave = Interleave::pingpong;
  parameters.block = 128;
  test::BundleRig rig(diffuse_furnace(0.5f), 384, 0.5f, {}, parameters);
  rig.set_direct(kPi);
  rig.solve(make_sequence(parameters, 1), 3 * 128);
  CHECK(rig.mean(rig.indirect()) == test::relative(0.875, 1e-5));
}

TEST_CASE("a shining box of glossy walls, against path tracing") {
  // Emission 1, Phong lobes k_s = 0.8, n = 5 and no diffuse one. Path traced mean E/pi: 1.5465 after one bounce, 1.8392
  // after two, 2.1800 of all.
  Scene scene;
  const int metal = add_metal(scene, "phong", glm::vec3(0.8f), std::pow(2.f / 7.f, 0.25f));
  scene.materials[metal].emissive_factor = glm::vec3(1);
  scene = test::box_scene({metal, metal, metal, metal, metal, metal}, std::move(scene));
  const double expected[] = {0.5465, 0.8392, 1.1800};
  for (int bounces = 1; bounces <= 3; ++bounces) {
    CAPTURE(bounces);
    Channels channels;
    channels.chains = true;
    channels.self_fed = bounces == 3;
    channels.count = channels.self_fed ? 1 : static_cast<uint32_t>(bounces);
    Parameters parameters;
    parameters.chain_share = 1;
    test::BundleRig rig(scene, 1536, 0.5f, channels, parameters, {{"LUCARIUM_PHONG", ""}});
    rig.solve(make_sequence(parameters, 3), test::full_run() ? 8192 : 512);
    CHECK(rig.mean(rig.indirect()) == test::relative(expected[bounces - 1], test::full_run() ? 0.005 : 0.01));
  }
}
