// SPDX-License-Identifier: Apache-2.0
// Form factors: a receiver of albedo 1 lit by an emitter of radiance 1 shows F on average. The orthographic camera
// stands between the two, since the backs of single-sided surfaces are opaque.
#include "test_render.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

Effort form_factor_effort() { return full_run() ? Effort{64, 16, 64} : Effort{32, 16, 64}; }

}  // namespace

TEST_CASE("form factors: parallel unit squares at distances 1 and 0.5") {
  ClosedForms table;
  for (const auto& [distance, exact] : {std::pair{1.f, .199825}, std::pair{.5f, .415253}}) {
    Scene scene;
    add_horizontal(scene, 0, 0, 0, 1, 1, true, add_material(scene, lambert(1)));
    add_horizontal(scene, 0, distance, 0, 1, 1, false, add_material(scene, emitter(1)));
    table.add("distance " + std::to_string(distance),
              estimate(scene, look_orthographic({0, 0.1f, 0}, {0, 0, 0}, 0.5f), direct_only(), form_factor_effort()),
              exact);
  }
  table.check(1e-3);
}

TEST_CASE("form factors: perpendicular unit squares with a common edge") {
  Scene scene;
  add_horizontal(scene, 0, 0, 0, 1, 1, true, add_material(scene, lambert(1)));
  // In the plane x = -0.5, facing +x.
  add_polygon(scene, {{-.5f, 0, .5f}, {-.5f, 0, -.5f}, {-.5f, 1, -.5f}, {-.5f, 1, .5f}},
              add_material(scene, emitter(1)));
  ClosedForms table;
  table.add("perpendicular",
            estimate(scene, look_orthographic({0, 0.1f, 0}, {0, 0, 0}, 0.5f), direct_only(), form_factor_effort()),
            .200044);
  table.check(2e-3);
}

TEST_CASE("form factors: coaxial disks") {
  ClosedForms table;
  for (const auto& [radius, exact] : {std::pair{1.f, .381966}, std::pair{.5f, .171573}}) {
    Scene scene;
    add_polygon(scene, disk_corners(0, radius, 512, true), add_material(scene, lambert(1)));
    add_polygon(scene, disk_corners(1, radius, 512, false), add_material(scene, emitter(1)));
    const float half = 1.01f * radius;
    Estimate mean =
        estimate(scene, look_orthographic({0, 0.1f, 0}, {0, 0, 0}, half), direct_only(), form_factor_effort());
    const double to_disk = 4 * double{half} * half / (M_PI * radius * radius);
    mean.mean *= to_disk;
    mean.error *= to_disk;
    table.add("radius " + std::to_string(radius), mean, exact);
  }
  table.check(2e-3);
}
