// SPDX-License-Identifier: Apache-2.0
// Glossy light from direction to direction (DirectionHistory): against path-traced values, against chains of rays in
// the same atlas, and where the sequence of directions is known to spoil it.
#include <doctest/doctest.h>

#include <cmath>

#include "glossy_box.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::bundle;
using test::glossy_channels;
using test::shining_box;

namespace {

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

/// Of the rays along `direction` that end at the box's walls across `axis`, the mean albedo of the walls where they
/// begin, white metal of the given roughness: the midpoint rule over the wall.
double sent_along(const glm::vec3& direction, int axis, double roughness) {
  constexpr int n = 512;
  const glm::dvec3 d = glm::abs(glm::dvec3(direction));
  double albedo[3], sum = 0;
  for (int b = 0; b < 3; ++b) albedo[b] = test::white_lobe_albedo(d[b], roughness);
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const double along[3] = {1 / d[axis], (i + 0.5) / n / d[u], (j + 0.5) / n / d[v]};
      const int first = along[0] < along[1] ? (along[0] < along[2] ? 0 : 2) : along[1] < along[2] ? 1 : 2;
      sum += albedo[first == 0 ? axis : first == 1 ? u : v];
    }
  return sum / (n * n);
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
  // The first direction brings emission of 1, of which the second sends the albedo of the lobe. A texel is met by rays
  // in proportion to its cosine.
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
    CHECK(light == test::relative(sent_along(sequence.at(1).direction, axis, 0.7), 0.02));
  }
}
