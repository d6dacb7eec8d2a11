// SPDX-License-Identifier: Apache-2.0
// A lamp that nearly touches what it lights.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "lucarium/scene/builtin/builder.h"
#include "lucarium/services/bvh/bvh.h"
#include "micro_fixture.h"
#include "micro_rendering/light/leaf_light.h"
#include "packed_node.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::micro;
using test::PackedNode;
using test::unpack;

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
  Device& device = *test::test_device();
  KernelScheduler scheduler(device.shared_from_this());
  SceneBuffers buffers(device, scene);
  Bvh bvh(device, scene, buffers);
  MicroParameters parameters;
  parameters.points_log2 = 15;
  parameters.micro_size = 8;
  const PointForest forest(device, scheduler, scene, buffers, {.points_log2 = parameters.points_log2}, "test");
  const GatherPass gather(device, parameters, micro::GatherAt::nodes);
  LeafLight light(device, scheduler, scene, buffers, bvh, forest, gather, parameters, 1, "test");
  constexpr double pi = 3.14159265358979;
  // What the portal brings to a point at (y, z) of the wall: four corner rectangles.
  const auto corner = [](double y, double z) {
    const double ry = std::sqrt(1 + y * y), rz = std::sqrt(1 + z * z);
    return 0.5 * (y / ry * std::atan(z / ry) + z / rz * std::atan(y / rz));
  };
  const auto irradiance = [&](const glm::dvec3& p) {
    const double y0 = (-0.1 - p.y) / 0.01, y1 = (0.1 - p.y) / 0.01, z0 = (-0.1 - p.z) / 0.01, z1 = (0.1 - p.z) / 0.01;
    return double{radiance} * (corner(y1, z1) - corner(y0, z1) - corner(y1, z0) + corner(y0, z0));
  };
  const std::vector<uint4> nodes = forest.nodes.download();
  const MicroTree& tree = forest.trees().front().record;
  const uint32_t count = forest.leaf_count();
  double expected = 0;
  for (uint32_t k = 0; k < count; ++k) {
    const PackedNode leaf = unpack(nodes[count + k]);
    const glm::dvec3 p = glm::dvec3(tree.origin_step.xyz()) + double{tree.origin_step.w} * glm::dvec3(leaf.center);
    if (leaf.normal.x > 0.9f) expected += irradiance(p);
  }
  constexpr uint32_t frames = 8;
  for (const uint32_t seed : {1u, 2u}) {
    double sum = 0, most = 0;
    for (uint32_t frame = 0; frame < frames; ++frame) {
      REQUIRE(light.receive(frame, seed));
      scheduler.finish();
      for (const float4& e : light.received().download()) {
        sum += double{e.x} / frames;
        most = std::max(most, double{e.x});
      }
    }
    MESSAGE("sum ", sum / expected, " of the light that there is, at most ", most / (pi * double{radiance}), " pi L");
    CHECK(sum == test::relative(expected, 0.03));
    CHECK(most <= 1.501 * pi * static_cast<double>(radiance));
  }
}
