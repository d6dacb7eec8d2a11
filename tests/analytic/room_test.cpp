// SPDX-License-Identifier: Apache-2.0
// The golden room: a single-sided Lambertian room with a box and a point light, whose floor irradiances were computed
// by an independent brute-force path tracer (each ±1e-4) and confirmed by Cycles for the first two bounces.
#include "lucarium/scene/builtin/scenes.h"
#include "test_render.h"

using namespace lucarium;
using namespace lucarium::test;

TEST_CASE("room: golden floor irradiances, direct and bounces 1 to 4") {
  struct Point {
    float x, z;
    double irradiance[5];
  };
  const Point points[] = {{-.5f, .3f, {.29302, .2931, .1698, .0970, .0545}},
                          {-.98f, -.97f, {.49353, .1709, .1506, .0895, .0557}},
                          {.8f, -.8f, {.18566, .1402, .0907, .0569, .0346}}};
  const double golden_uncertainty = 1e-4;
  const double floor_albedo = 0.7;
  const Effort effort = full_run() ? Effort{64, 16, 1024} : Effort{32, 16, 32};
  const Scene scene = make_builtin_scene("room");
  ClosedForms table;
  for (const Point& point : points) {
    const SceneCamera camera = look_orthographic({point.x, 0.01f, point.z}, {point.x, 0, point.z}, 1e-5f);
    std::vector<double> before(effort.replicates, 0.0);
    for (int bounces = 0; bounces <= 4; ++bounces) {
      PathIntegratorOptions options;
      options.path_set.max_bounces = bounces;
      // The same random numbers for every limit: the difference is the bounce.
      std::vector<double> means = replicate_means(scene, camera, options, effort);
      std::vector<double> bounce(means.size());
      for (size_t r = 0; r < means.size(); ++r) bounce[r] = (means[r] - before[r]) * M_PI / floor_albedo;
      before = means;
      table.add("(" + std::to_string(point.x) + ", " + std::to_string(point.z) + ") bounce " + std::to_string(bounces),
                estimate_of(bounce), point.irradiance[bounces], golden_uncertainty);
    }
  }
  // The light is near two walls, whose bright spots make the later bounces noisy.
  table.check(0.03);
}
