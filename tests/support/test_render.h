// SPDX-License-Identifier: Apache-2.0
// Renders of the path integrator, and their means with standard errors.
#pragma once
#include <doctest/doctest.h>

#include <memory>
#include <vector>

#include "closed_forms.h"
#include "device_fixture.h"
#include "lucarium/services/bvh/bvh.h"
#include "lucarium/services/path_integrator/path_integrator.h"
#include "made_scene.h"

namespace lucarium::test {

/// How much to render. All pixels of one estimate share an exact value (or their mean has one).
struct Effort {
  uint32_t side = 32;  ///< pixels per image side
  uint32_t replicates = 16;
  uint32_t samples_per_replicate = 16;
};
inline Effort usual_effort() { return full_run() ? Effort{64, 16, 64} : Effort{32, 16, 16}; }

inline PathIntegratorOptions limited(int max_bounces, PathEstimator estimator = PathEstimator::mis) {
  PathIntegratorOptions options;
  options.path_set.max_bounces = max_bounces;
  options.estimator = estimator;
  return options;
}
inline PathIntegratorOptions direct_only(PathEstimator estimator = PathEstimator::mis) { return limited(0, estimator); }

/// Everything an integrator needs to render one scene.
struct TestRender {
  TestRender(const Scene& scene, const SceneCamera& camera, const PathIntegratorOptions& options, uint32_t side,
             uint64_t seed = 1)
      : scheduler(test_device()), buffers(*test_device(), scene), bvh(*test_device(), scene, buffers) {
    frame.camera = make_camera(camera, 1);
    frame.width = frame.height = side;
    integrator = std::make_unique<PathIntegrator>(*test_device(), scheduler, buffers, bvh, frame, options, "test");
    integrator->reset(seed);
  }
  KernelScheduler scheduler;
  SceneBuffers buffers;
  Bvh bvh;
  Frame frame{};
  std::unique_ptr<PathIntegrator> integrator;
};

/// Mean over the image of the first channel, of each replicate.
inline std::vector<double> replicate_means(const Scene& scene, const SceneCamera& camera, PathIntegratorOptions options,
                                           const Effort& effort, uint64_t seed = 1) {
  options.replicates = effort.replicates;
  options.samples_per_iteration = effort.replicates * effort.samples_per_replicate;
  TestRender render(scene, camera, options, effort.side, seed);
  REQUIRE(render.integrator->iterate());
  std::vector<double> means;
  for (const std::vector<float>& image : render.integrator->replicate_images()) {
    double sum = 0;
    for (size_t p = 0; p < image.size(); p += 3) sum += image[p];
    means.push_back(sum / (static_cast<double>(image.size()) / 3));
  }
  return means;
}

inline Estimate estimate(const Scene& scene, const SceneCamera& camera, const PathIntegratorOptions& options,
                         const Effort& effort, uint64_t seed = 1) {
  return estimate_of(replicate_means(scene, camera, options, effort, seed));
}

}  // namespace lucarium::test
