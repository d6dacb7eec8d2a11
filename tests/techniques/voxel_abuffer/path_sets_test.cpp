// SPDX-License-Identifier: Apache-2.0
// Modes of voxel_abuffer against the path tracer with their own path sets: the image test on blocks of 8 x 8 pixels.
#include <doctest/doctest.h>

#include <cmath>

#include "lucarium/conformance/block_comparison.h"
#include "lucarium/scene/load/load_scene.h"
#include "mode_scenes.h"
#include "technique_picture.h"
#include "test_support.h"

using namespace lucarium;
using namespace lucarium::test;
using namespace std::string_literals;

namespace {

struct PathSetCase {
  std::string mode;
  int max_bounces;
  Parameters reference;
  uint64_t iterations;  ///< of two samples in a quick run
};
const std::vector<PathSetCase> kPathSets = {
    {"cast", 0, {{"eye_deltas", "0"}}, 8}, {"whitted", 0, {{"eye_deltas", "3"}}, 8}, {"path", 2, {}, 24}};

constexpr uint32_t kSide = 32, kPictures = 8;

Picture picture_of(const PathSetCase& c) {
  return {.size = kSide, .iterations = (full_run() ? 4 : 1) * c.iterations, .seed = 1, .max_bounces = c.max_bounces};
}
std::vector<std::vector<float>> ours(const Scene& scene, const PathSetCase& c, Parameters parameters) {
  parameters.emplace_back("mode", c.mode);
  parameters.emplace_back("lambda", "2");
  return pictures(scene, picture_of(c), parameters, kPictures);
}
std::vector<std::vector<float>> references(const Scene& scene, const PathSetCase& c) {
  Picture picture = picture_of(c);
  picture.technique = "path_tracing";
  picture.iterations *= 4;
  picture.seed = 1000;
  return pictures(scene, picture, c.reference, kPictures);
}

/// Pictures of the same seeds: what both have in common is no noise of their difference.
check::BlockTest compare_pairs(std::vector<std::vector<float>> a, const std::vector<std::vector<float>>& b) {
  std::vector<float> mean(b[0].size());
  for (size_t i = 0; i < mean.size(); ++i)
    for (const std::vector<float>& image : b) mean[i] += image[i] / static_cast<float>(b.size());
  for (size_t k = 0; k < a.size(); ++k)
    for (size_t i = 0; i < mean.size(); ++i) a[k][i] += mean[i] - b[k][i];
  return check::compare_blocks(std::move(a), std::vector(b.size(), mean), kSide, kSide);
}

}  // namespace

TEST_CASE("path sets: modes have the light of the path tracer with their paths, block by block") {
  const Scene open = showcase(), closed = closed_showcase();
  for (const PathSetCase& c : kPathSets) {
    CAPTURE(c.mode);
    const check::BlockTest exact = check::compare_blocks(
        ours(open, c, {{"intersect", "exact"}, {"abuffer_size", "256"}}), references(open, c), kSide, kSide);
    MESSAGE(c.mode, ", exact: ", exact.describe(0));
    CHECK(exact.passes(0));
    CHECK(exact.noise < 0.01);
    // Closed components by parity beside open ones by exact search.
    if (full_run() || c.mode == "whitted") {
      const check::BlockTest both =
          check::compare_blocks(ours(open, c, {{"intersect", "auto"}}), references(open, c), kSide, kSide);
      MESSAGE(c.mode, ", auto: ", both.describe(0.01));
      CHECK(both.passes(0.01));
      CHECK(both.noise < 0.01);
    }
    const check::BlockTest parity =
        check::compare_blocks(ours(closed, c, {{"intersect", "parity"}}), references(closed, c), kSide, kSide);
    MESSAGE(c.mode, ", parity: ", parity.describe(0.01));
    CHECK(parity.passes(0.01));
    CHECK(parity.noise < 0.01);
  }
}

TEST_CASE("path sets: in closed scenes parity errs by less than a hundredth in every mode") {
  struct Case {
    std::string name;
    Scene scene;
  };
  for (const Case& s : {Case{"showcase", closed_showcase()}, {"solids", load_scene("builtin:solids")}}) {
    CAPTURE(s.name);
    if (s.name == "showcase" && !full_run()) continue;
    for (const PathSetCase& c : kPathSets) {
      CAPTURE(c.mode);
      const std::vector<std::vector<float>> exact = ours(s.scene, c, {{"intersect", "exact"}});
      for (const char* search : {"2d", "3", "1"}) {
        CAPTURE(search);
        const check::BlockTest test =
            compare_pairs(ours(s.scene, c, {{"intersect", "parity"}, {"search", search}}), exact);
        MESSAGE(s.name, ", ", c.mode, ", ", std::string(search), ": ", test.describe(0.01));
        CHECK(test.rms + 2 * test.noise <= 0.01);
      }
    }
  }
}
