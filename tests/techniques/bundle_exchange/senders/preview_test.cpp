// SPDX-License-Identifier: Apache-2.0
// Smoothing of what has not converged: within charts only, as far as errors go, and never in the result.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "bundle_rig.h"
#include "technique_rig.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::bundle;

namespace {

Scene box() {
  Scene scene;
  const int wall = add_lambert(scene, "wall", glm::vec3(0.5f));
  return test::box_scene({wall, wall, wall, wall, wall, wall}, std::move(scene));
}

/// Image of a session of Cornell's box that has done at least `directions`.
std::vector<float> image(const test::Options& options, double directions) {
  const auto run = test::session("bundle_exchange", load_scene("builtin:cornell"), -1, options);
  do run->run({.iterations = 1});
  while (run->technique().counters().at("directions") < directions);
  return test::indirect(*run);
}

double distance(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += std::pow(double(a[i]) - double(b[i]), 2);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

}  // namespace

TEST_CASE("smoothing takes noise away where it is known to be noise, and crosses no edge of a chart") {
  test::BundleRig rig(box(), 1536, 0.5f);
  rig.solve(make_sequence({}, 1), 8);
  const std::vector<SurfacePoint> points = rig.points();
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0, 0.1f);
  std::vector<float> walls, noisy;
  for (uint32_t side = 0; side < rig.sides(); ++side) {
    const float4& n = points[side].normal;
    walls.push_back(3 + n.x + 2 * n.y + (n.z > 0.5f ? 0.5f : n.z < -0.5f ? -0.5f : 0));
    noisy.push_back(walls.back() + noise(random));
  }
  // Errors as large as anything: whatever could bleed would.
  const std::vector<double> whole = rig.smooth(walls, 100);
  double worst = 0;
  for (uint32_t side = 0; side < rig.sides(); ++side)
    worst = std::max(worst, std::abs(whole[side] - double(walls[side])));
  CHECK(worst < 1e-5);
  const auto error = [&](const std::vector<double>& values) {
    double sum = 0;
    for (uint32_t side = 0; side < rig.sides(); ++side) sum += std::pow(values[side] - double(walls[side]), 2);
    return std::sqrt(sum / rig.sides());
  };
  CHECK(error(rig.smooth(noisy, 0.01f)) < 0.03);  // of 0.1
  const std::vector<double> sharp = rig.smooth(noisy, 0);
  worst = 0;
  for (uint32_t side = 0; side < rig.sides(); ++side)
    worst = std::max(worst, std::abs(sharp[side] - double(noisy[side])));
  CHECK(worst < 1e-6);
}

TEST_CASE("a preview is nearer to what it becomes, and becomes the same") {
  const test::Options options = {{"texels", "16384"}, {"batch", "1"}, {"stop_error", "0"}, {"direct_mode", "exchange"}};
  const auto with = [&](const char* preview, const char* directions) {
    return test::with(options, {{"preview", preview}, {"directions", directions}});
  };
  const std::vector<float> converged = image(with("off", "4096"), 4096);
  const double plain = distance(image(with("off", "4096"), 64), converged),
               smooth = distance(image(with("on", "4096"), 64), converged);
  MESSAGE("error after 64 directions ", plain, ", of the preview ", smooth);
  CHECK(smooth < 0.85 * plain);
  CHECK(image(with("on", "128"), 128) == image(with("off", "128"), 128));
}

TEST_CASE("a preview shows exchanged direct light while bundles carry nothing else") {
  const auto run =
      test::session("bundle_exchange", load_scene("builtin:cornell"), -1,
                    {{"texels", "2048"}, {"direct_mode", "exchange"}, {"direct_first", "4096"}, {"preview", "on"}});
  run->run({.iterations = 2});
  CHECK(run->technique().counters().at("indirect_directions") == 0);
  CHECK(test::mean(run->resolve().find("direct")->pixels) > 0);
}
