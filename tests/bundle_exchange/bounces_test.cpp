// SPDX-License-Identifier: Apache-2.0
// Bounces: furnaces whose every bounce is known, a room and a glossy box against path-traced values.
#include <doctest/doctest.h>

#include <array>
#include <cmath>

#include "bundle_rig.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::bundle;

namespace {

constexpr float kPi = 3.14159265f;

Scene furnace(float albedo) {
  Scene scene;
  const int wall = add_lambert(scene, "wall", glm::vec3(albedo));
  return test::box_scene({wall, wall, wall, wall, wall, wall}, std::move(scene));
}

/// The same deficit of a running mean by its recurrence along given directions, with walls that are uniform: where a
/// direction has components a, a wall across axis i counts a_i, and sees what the lines that reach it leave: the opposite
/// wall, or one of the others. At each step a wall's mean moves by a_i over the sum of a_i so far, so that the first few
/// directions decide much; only the mean over seeds is that of steps 1/i. The film's pixels must be small against texels: with
/// 0.7 of their edge, early directions miss some texels, and the box lacks 0.7 % more.
double running_deficit(const DirectionSequence& sequence, double albedo, int count) {
  std::array<double, 3> deficit{1, 1, 1}, sum{}, weight{};
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 a = glm::max(glm::abs(glm::dvec3(sequence.at(i).direction)), 1e-9);
    for (int axis = 0; axis < 3; ++axis) {
      const int j = (axis + 1) % 3, k = (axis + 2) % 3;
      const double across = 1 / a[axis], along_j = 1 / a[j], along_k = 1 / a[k];  // lengths of lines between walls
      const double opposite = std::max(0., 1 - across / along_j) * std::max(0., 1 - across / along_k);
      const double reach = std::min({across, along_j, along_k});
      const double side_j = (reach - reach * reach / (2 * along_k)) / along_j;
      const double side_k = (reach - reach * reach / (2 * along_j)) / along_k;
      sum[axis] += a[axis] * albedo * (opposite * deficit[axis] + side_j * deficit[j] + side_k * deficit[k]);
      weight[axis] += a[axis];
    }
    for (int axis = 0; axis < 3; ++axis) deficit[axis] = sum[axis] / weight[axis];
  }
  return -(deficit[0] + deficit[1] + deficit[2]) / 3;
}

/// Relative deficit of indirect light in a box of emission 1 and albedo 0.8, after 2048 directions.
double furnace_deficit(Interleave interleave, bool balance, uint64_t seed = 1, float pixel_size = 0.7f) {
  Parameters parameters;
  parameters.batch = 1;
  parameters.directions = 2048;
  parameters.interleave = interleave;
  parameters.balance = balance;
  test::BundleRig rig(furnace(0.8f), 96, pixel_size, {}, parameters);
  rig.set_direct(kPi);
  rig.solve(DirectionSequence(parameters, seed, nullptr), 2048);
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
  const auto predicted = [](uint64_t seed) { return running_deficit(DirectionSequence(Parameters(), seed, nullptr), 0.8, 2048); };
  double mean = 0;
  for (uint64_t seed = 1; seed <= 64; ++seed) mean += predicted(seed) / 64;
  CHECK(std::abs(mean + 0.187) < 0.003);
  for (const uint64_t seed : {1u, 2u}) {
    CAPTURE(seed);
    const double measured = furnace_deficit(Interleave::running, false, seed, 0.24f);
    MESSAGE("measured ", measured, ", predicted ", predicted(seed));
    CHECK(std::abs(measured - predicted(seed)) < 0.003);
  }
}

TEST_CASE("bounce after bounce: with a limit, and one by one") {
  for (const uint32_t bounces : {1u, 2u, 3u}) {
    Parameters parameters;
    Channels channels;
    channels.self_fed = false;
    channels.count = bounces;
    test::BundleRig rig(furnace(0.5f), 384, 0.5f, channels, parameters);
    rig.set_direct(kPi);
    rig.solve(DirectionSequence(parameters, 1, nullptr), 1024);
    double expected = 0;
    for (uint32_t k = 1; k <= bounces; ++k) expected += std::pow(0.5, k);
    CHECK(rig.mean(rig.indirect()) == test::relative(expected, 0.004));
  }
  Parameters parameters;
  parameters.interleave = Interleave::pingpong;
  parameters.block = 128;
  test::BundleRig rig(furnace(0.5f), 384, 0.5f, {}, parameters);
  rig.set_direct(kPi);
  rig.solve(DirectionSequence(parameters, 1, nullptr), 3 * 128);
  CHECK(rig.mean(rig.indirect()) == test::relative(0.875, 1e-5));
}

TEST_CASE("a room with a lamp, all light by bundles, against path tracing") {
  // Albedos: floor 0.6, ceiling 0.7, walls x 0.25 and 0.6, z 0.7 and 0.5; a patch of 0.25 m of the ceiling's albedo with
  // L = 20 in its middle. All that the patch emits arrives: mean E/pi over the six walls, the patch among them, is
  // 20 / 16 / 6 direct; path traced, 0.2491 indirect.
  Scene scene;
  std::array<int, 6> walls{};
  const float albedos[6] = {0.25f, 0.6f, 0.6f, 0.7f, 0.7f, 0.5f};
  for (int i = 0; i < 6; ++i) walls[i] = add_lambert(scene, "wall", glm::vec3(albedos[i]));
  const int lamp = add_emitter(scene, "lamp", glm::vec3(20));
  scene.materials[lamp].base_color = glm::vec4(0.7f, 0.7f, 0.7f, 1);
  scene = test::box_scene(walls, std::move(scene));
  const float y = 0.9999f;
  add_instance(scene, add_mesh(scene, MeshBuilder("lamp").quad({.375f, y, .375f}, {.625f, y, .375f}, {.625f, y, .625f}, {.375f, y, .625f}).take()), lamp);
  Parameters parameters;
  parameters.direct_mode = DirectMode::exchange;
  Channels channels;
  channels.emission = true;
  channels.count = 2;
  test::BundleRig rig(scene, 1536, 0.5f, channels, parameters);
  const uint64_t count = test::full_run() ? 32768 : 2048;
  rig.solve(DirectionSequence(parameters, 2, nullptr), count);
  const std::vector<AtlasMaterial> materials = rig.materials();
  const std::vector<SurfacePoint> points = rig.points();
  // Not what is hidden behind the lamp.
  const auto counts = [&](uint32_t slot) {
    const float4& p = points[slot].position;
    const bool behind = p.y > 0.99f && std::abs(p.x - .5f) < .125f && std::abs(p.z - .5f) < .125f;
    return materials[slot].emission.x > 0 || !behind;
  };
  const double tolerance = test::full_run() ? 0.004 : 0.015;
  CHECK(rig.mean(rig.direct(), counts) == test::relative(20. / 16 / 6, tolerance));
  CHECK(rig.mean(rig.indirect(), counts) == test::relative(0.2491, tolerance));
  CHECK(rig.relative_error() < 0.15);  // of a slot; the mean is better
  CHECK(rig.relative_error() > 0.01);
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
    channels.hops = true;
    channels.self_fed = bounces == 3;
    channels.count = channels.self_fed ? 1 : static_cast<uint32_t>(bounces);
    Parameters parameters;
    parameters.hop_share = 1;
    test::BundleRig rig(scene, 1536, 0.5f, channels, parameters, {{"LUCARIUM_PHONG", ""}});
    rig.solve(DirectionSequence(parameters, 3, nullptr), test::full_run() ? 8192 : 512);
    CHECK(rig.mean(rig.indirect()) == test::relative(expected[bounces - 1], test::full_run() ? 0.005 : 0.01));
  }
}
