// SPDX-License-Identifier: Apache-2.0
// The image test on renders: two seeds of one scene agree, and a hundredth of the energy does not pass.
#include "lucarium/statistics/image_comparison.h"

#include "lucarium/scene/builtin/scenes.h"
#include "test_render.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

std::vector<std::vector<float>> replicates_of(const std::string& name, uint64_t seed, PathEstimator estimator) {
  const uint32_t replicates = full_run() ? 32 : 16;
  PathIntegratorOptions options;
  options.estimator = estimator;
  options.replicates = replicates;
  options.samples_per_iteration = replicates * (full_run() ? 128 : 8);
  const Scene scene = make_builtin_scene(name);
  TestRender render(scene, scene.cameras.at(0), options, 64, seed);
  REQUIRE(render.integrator->iterate());
  return render.integrator->replicate_images();
}

ImageEstimate estimate_of_images(std::vector<std::vector<float>> images, float scale = 1) {
  for (std::vector<float>& image : images)
    for (float& value : image) value *= scale;
  return ImageEstimate::from_replicates(64, 64, std::move(images));
}

}  // namespace

TEST_CASE("image test: independent renders pass, one per cent of energy fails") {
  std::vector<std::string> scenes = {"cornell"};
  if (full_run()) scenes.push_back("cornell-glossy");
  for (const std::string& name : scenes) {
    const auto images = replicates_of(name, 1, PathEstimator::mis),
               others = replicates_of(name, 2, PathEstimator::mis_balance);
    const ImageEstimate a = estimate_of_images(images), b = estimate_of_images(others);
    const ImageTest same = test_images(a, b);
    INFO(name, "\n", to_text(same));
    if (full_run()) MESSAGE(name, "\n", to_text(same));
    CHECK(same.passed);
    CHECK(same.levels[0].tests > 8000);
    const ImageTest brighter = test_images(a, estimate_of_images(others, 1.01f));
    INFO(to_text(brighter));
    CHECK_FALSE(brighter.passed);
    CHECK(brighter.levels[2].failures > 0);
  }
}
