// SPDX-License-Identifier: Apache-2.0
// A lamp that nearly touches what it lights.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "leaf_rig.h"
#include "lucarium/base/numbers.h"
#include "lucarium/scene/builtin/builder.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::micro;
using test::LeafRig;

TEST_CASE("a bright portal close to a wall: no leaf has more light than it radiates, with one sample as with many") {
  // A cube of 2 m; 1 cm before its left wall a square portal of 20 cm that shines at the wall (its normal is -x).
  Scene scene;
  scene.source = "test:portal";
  MeshBuilder box("box"), portal("portal");
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side) box.box_face({-1, -1, -1}, {1, 1, 1}, axis, side, true);
  portal.quad({-0.99f, -0.1f, -0.1f}, {-0.99f, -0.1f, 0.1f}, {-0.99f, 0.1f, 0.1f}, {-0.99f, 0.1f, -0.1f});
  add_instance(scene, add_mesh(scene, box.take()), add_lambert(scene, "grey", glm::vec3(0.5f)));
  const float radiance = 70;
  add_instance(scene, add_mesh(scene, portal.take()), add_emitter(scene, "portal", glm::vec3(radiance)));
  MicroParameters parameters;
  parameters.points_log2 = 15;
  parameters.micro_size = 8;
  LeafRig rig(scene, parameters);
  LeafLight light = rig.light(1);
  // What the portal brings to a point at (y, z) of the wall: four corner rectangles.
  const auto corner = [](double y, double z) {
    const double ry = std::sqrt(1 + y * y), rz = std::sqrt(1 + z * z);
    return 0.5 * (y / ry * std::atan(z / ry) + z / rz * std::atan(y / rz));
  };
  const auto irradiance = [&](const glm::dvec3& p) {
    const double y0 = (-0.1 - p.y) / 0.01, y1 = (0.1 - p.y) / 0.01, z0 = (-0.1 - p.z) / 0.01, z1 = (0.1 - p.z) / 0.01;
    return double{radiance} * (corner(y1, z1) - corner(y0, z1) - corner(y1, z0) + corner(y0, z0));
  };
  double expected = 0;
  for (const LeafRig::Leaf& leaf : rig.leaves())
    if (leaf.normal.x > 0.9f) expected += irradiance(leaf.position);
  constexpr uint32_t frames = 8;
  for (const uint32_t seed : {1u, 2u}) {
    double sum = 0, most = 0;
    for (uint32_t frame = 0; frame < frames; ++frame) {
      for (const float4& e : rig.receive(light, frame, seed)) {
        sum += double{e.x} / frames;
        most = std::max(most, double{e.x});
      }
    }
    MESSAGE("sum ", sum / expected, " of the light that there is, at most ", most / (pi * double{radiance}), " pi L");
    CHECK(sum == test::relative(expected, 0.03));
    CHECK(most <= 1.501 * pi * static_cast<double>(radiance));
  }
}
