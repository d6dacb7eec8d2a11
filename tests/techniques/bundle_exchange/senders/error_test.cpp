// SPDX-License-Identifier: Apache-2.0
// The relative error that a run states of itself, against what runs differ by.
#include <doctest/doctest.h>

#include <cmath>

#include "bundle_rig.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::bundle;

TEST_CASE("the relative error is what runs of independent directions differ by") {
  Scene scene;
  const int wall = add_lambert(scene, "wall", glm::vec3(0.8f));
  Parameters parameters;
  parameters.batch = 1;
  parameters.sequence = DirectionOrder::iid;
  parameters.access_gap = 0;
  Channels channels;
  channels.self_fed = false;  // one bounce, so that batches are independent
  test::BundleRig rig(test::box_scene({wall, wall, wall, wall, wall, wall}, std::move(scene)), 96, 0.25f, channels,
                      parameters);
  const std::vector<SurfacePoint> points = rig.points();
  rig.set_direct([&](uint32_t side) { return points[side].position.x < 0.5f ? 3.f : 0.1f; });
  const int runs = 32;
  std::vector<double> sum(rig.sides()), squares(rig.sides());
  double stated = 0;
  for (int run = 0; run < runs; ++run) {
    rig.reset();
    rig.solve(make_sequence(parameters, static_cast<uint64_t>(run + 1)), 128);
    const std::vector<double> light = rig.indirect();
    for (uint32_t side = 0; side < rig.sides(); ++side) {
      sum[side] += light[side];
      squares[side] += light[side] * light[side];
    }
    stated += rig.relative_error() / runs;
  }
  std::vector<double> mean, deviation;
  for (uint32_t side = 0; side < rig.sides(); ++side) {
    mean.push_back(sum[side] / runs);
    deviation.push_back(std::sqrt((squares[side] - sum[side] * sum[side] / runs) / (runs - 1)));
  }
  const double measured = rig.mean(deviation) / rig.mean(mean);
  MESSAGE("stated ", stated, ", measured ", measured);
  CHECK(stated == test::relative(measured, 0.1));
}
