// SPDX-License-Identifier: Apache-2.0
// Glossy light from direction to direction (DirectionHistory): against path-traced values, against chains of rays in
// the same atlas, and where the sequence of directions is known to spoil it.
#include <doctest/doctest.h>

#include <cmath>

#include "bundle_rig.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::bundle;

namespace {

/// A box of emission 1 whose walls have specular lobes only.
Scene shining_box(float k, float roughness) {
  Scene scene;
  const int metal = add_metal(scene, "metal", glm::vec3(k), roughness);
  scene.materials[metal].emissive_factor = glm::vec3(1);
  return test::box_scene({metal, metal, metal, metal, metal, metal}, std::move(scene));
}

Channels glossy_channels(int bounces) {
  Channels channels;
  channels.chains = channels.emission = channels.to_history = true;
  channels.self_fed = bounces == 0;
  channels.count = 1 + (channels.self_fed ? 1 : static_cast<uint32_t>(bounces));
  return channels;
}

Parameters history(int window, GlossyNorm norm) {
  Parameters parameters;
  parameters.glossy_window = window;
  parameters.glossy_norm = norm;
  parameters.history_alpha = 0.01f;
  return parameters;
}

/// Mean indirect E/π of the box's walls. direct: irradiance that diffuse lobes reflect.
double mean_light(const Scene& scene, const Parameters& parameters, int bounces, int directions, bool phong,
                  float direct = 0) {
  std::map<std::string, std::string> defines;
  if (phong) defines["LUCARIUM_PHONG"] = "";
  test::BundleRig rig(scene, 600, 0.5f, glossy_channels(bounces), parameters, defines);
  if (direct > 0) rig.set_direct(direct);
  rig.solve(make_sequence(parameters, 3, nullptr, true), static_cast<uint64_t>(directions));
  return rig.mean(rig.indirect());
}

}  // namespace

TEST_CASE("a shining box of Phong walls, by directions that reflect those before them") {
  // k_s = 0.8, n = 5; path traced: 0.5465 after one bounce, 0.8392 after two.
  const Scene scene = shining_box(0.8f, std::pow(2.f / 7.f, 0.25f));
  const int directions = test::full_run() ? 32768 : 4096;
  const double tolerance = test::full_run() ? 0.005 : 0.015;
  Parameters parameters = history(32, GlossyNorm::mean);
  CHECK(mean_light(scene, parameters, 1, directions, true) == test::relative(0.5465, tolerance));
  CHECK(mean_light(scene, parameters, 2, directions, true) == test::relative(0.8392, tolerance));
  // Successive Halton points are no pairs of independent directions.
  parameters = history(1, GlossyNorm::mean);
  parameters.sequence = DirectionOrder::halton;
  CHECK(std::abs(mean_light(scene, parameters, 1, directions, true) / 0.5465 - 1) > 0.05);
}

TEST_CASE("metal walls: chains of rays and the direction history agree") {
  const Scene scene = shining_box(0.8f, 0.7f);
  for (const int bounces : {1, 0}) {
    CAPTURE(bounces);
    Parameters chains;
    chains.chain_share = 1;
    const double expected = mean_light(scene, chains, bounces, test::full_run() ? 8192 : 256, false);
    for (const GlossyNorm norm : {GlossyNorm::self, GlossyNorm::mean}) {
      if (norm == GlossyNorm::mean && bounces == 0) continue;
      CAPTURE(static_cast<int>(norm));
      CHECK(mean_light(scene, history(32, norm), bounces, test::full_run() ? 16384 : 2048, false) ==
            test::relative(expected, test::full_run() ? 0.005 : 0.015));
    }
  }
}

TEST_CASE("walls of a diffuse and a glossy lobe together: chains of rays and the direction history agree") {
  Scene scene;
  const int plastic = add_dielectric(scene, "plastic", glm::vec3(0.5f), 0.7f);
  scene.materials[plastic].ior = 2.5f;
  scene.materials[plastic].emissive_factor = glm::vec3(1);
  scene = test::box_scene({plastic, plastic, plastic, plastic, plastic, plastic}, std::move(scene));
  Parameters chains;
  chains.chain_share = 1;
  const double expected = mean_light(scene, chains, 1, 256, false, 3.14159265f),
               glossy = mean_light(scene, chains, 1, 256, false);
  CHECK(glossy > 0.1 * expected);
  CHECK(glossy < 0.5 * expected);
  CHECK(mean_light(scene, history(32, GlossyNorm::self), 1, 2048, false, 3.14159265f) ==
        test::relative(expected, 0.01));
}

TEST_CASE("a window of one: a direction sends what the one before it has brought, not what was there before that") {
  Parameters parameters = history(1, GlossyNorm::self);
  parameters.batch = 1;
  parameters.average_exponent = 0;
  test::BundleRig rig(shining_box(1, 0.7f), 600, 0.1f, glossy_channels(1), parameters);
  const DirectionSequence sequence = make_sequence(parameters, 3, nullptr, true);
  rig.solve(sequence, 2);
  // The first direction brings emission of 1, of which the second sends the albedo of the lobe, between 0.65 and 0.85.
  // A texel is met by rays in proportion to its cosine.
  const std::vector<double> found = rig.indirect();
  const std::vector<SurfacePoint> points = rig.points();
  for (int axis = 0; axis < 3; ++axis) {
    CAPTURE(axis);
    const double first = std::abs(double{sequence.at(0).direction[axis]}),
                 second = std::abs(double{sequence.at(1).direction[axis]});
    const double light = rig.mean(found, [&](uint32_t side) {
      const SurfacePoint& p = points[side];
      return std::abs(axis == 0 ? p.normal.x : axis == 1 ? p.normal.y : p.normal.z) > 0.5f;
    }) / (second / (first + second));
    MESSAGE("albedo ", light);
    CHECK(light > 0.65);
    CHECK(light < 0.85);
  }
}
