// SPDX-License-Identifier: Apache-2.0
// Light of one number of scatterings at a time, against path tracing with the same limits. Classes are the direct
// layer, and differences of indirect layers of which one allows a bounce more: both techniques repeat their random
// numbers, so that light of fewer bounces cancels.
#include <doctest/doctest.h>

#include "technique_rig.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// Mean over image and colours of light with 1, 2, … scatterings (max_bounces 0 to `most`, each less the one before).
std::vector<double> classes(const std::string& technique, const char* scene, uint64_t iterations,
                            const Options& options, int most = 3) {
  std::vector<double> result;
  double before = 0;
  for (int bounces = 0; bounces <= most; ++bounces) {
    const auto run = session(technique, load_scene(scene), bounces, options);
    run->run({.iterations = iterations});
    const double direct = mean(run->resolve().find("direct")->pixels), indirect = mean(test::indirect(*run));
    if (bounces == 0) CHECK(indirect == 0.0);
    result.push_back(bounces == 0 ? direct : indirect - before);
    before = indirect;
  }
  return result;
}

void compare(const char* scene, const std::vector<double>& expected, const Options& options, double tolerance) {
  const std::vector<double> found =
      classes("bundle_exchange", scene, test::full_run() ? 64 : 24, options, static_cast<int>(expected.size()) - 1);
  for (size_t bounces = 0; bounces < found.size(); ++bounces) {
    CAPTURE(bounces);
    MESSAGE(std::string(scene), ", ", options.back().second, ", ", bounces,
            " bounces: ", found[bounces] / expected[bounces] - 1);
    CHECK(found[bounces] == test::relative(expected[bounces], tolerance));
  }
}

const Options paths = {{"samples_per_iteration", "64"}};

}  // namespace

TEST_CASE("each number of bounces alone brings the path tracer's light: diffuse walls") {
  const std::vector<double> expected = classes("path_tracing", "builtin:cornell", test::full_run() ? 32 : 8, paths);
  compare("builtin:cornell", expected, with(few_texels, {{"direct_mode", "nee"}}), 0.02);
  compare("builtin:cornell", expected, with(few_texels, {{"direct_mode", "exchange"}}), 0.02);
}

TEST_CASE("each number of bounces alone brings the path tracer's light: glossy, mirror and glass") {
  // In full a minute: quickly, light of two bounces at most.
  const bool full = test::full_run();
  const std::vector<double> expected = classes("path_tracing", "builtin:spheres", full ? 64 : 16, paths, full ? 3 : 1);
  compare("builtin:spheres", expected, with(few_texels, {{"texels", full ? "16384" : "8192"}, {"direct_mode", "nee"}}),
          full ? 0.03 : 0.05);
}
