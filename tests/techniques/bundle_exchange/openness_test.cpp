// SPDX-License-Identifier: Apache-2.0
// A texel that is partly covered by something near is as bright as what of it is seen.
#include <doctest/doctest.h>

#include "bundle_rig.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::bundle;

namespace {

constexpr float kEdge = 0.53f;  // x of the slab's side, within texels of the floor

/// A floor of a square metre under a sky of radiance 1, and just above it a slab that covers all x < kEdge.
Scene floor_and_slab() {
  Scene scene;
  const int white = add_lambert(scene, "white", glm::vec3(0.5f));
  add_instance(scene, add_mesh(scene, MeshBuilder("floor").box_face({0, 0, 0}, {1, 1, 1}, 1, 0, true).take()), white);
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side)
      add_instance(
          scene,
          add_mesh(
              scene,
              MeshBuilder("slab").box_face({-0.5f, 0.001f, -0.5f}, {kEdge, 0.002f, 1.5f}, axis, side, false).take()),
          white);
  Environment sky;
  sky.width = 2, sky.height = 1;
  sky.radiance.assign(2, glm::vec3(1));
  scene.environment = sky;
  return scene;
}

/// Of the floor's texels that the slab's side crosses: irradiance over π, by what each counts; and their number.
struct Crossed {
  double mean = 0, counted = 0, area = 0;
  int texels = 0;
};
Crossed light_of_crossed(float open_gap) {
  Channels channels;
  channels.emission = true;
  Parameters parameters;
  parameters.open_gap = open_gap;
  test::BundleRig rig(floor_and_slab(), 320, 0.5f, channels, parameters);
  rig.send([](uint32_t) { return glm::vec3(0); });
  rig.run(make_sequence(parameters, 3), 512);
  const std::vector<glm::dvec4> sums = rig.sums();
  const std::vector<float> openness = rig.openness();
  const std::vector<AtlasTexel> texels = rig.texels();
  const std::vector<SurfacePoint> points = rig.points();
  Crossed result;
  for (uint32_t slot = 0; slot < rig.slots(); ++slot) {
    if (rig.instance_of(texels[slot].triangle) != 0) continue;
    const double edge = std::sqrt(double{texels[slot].area}), x = points[slot].position.x;
    if (std::abs(x - double{kEdge}) > 0.3 * edge) continue;
    const double counted = double{texels[slot].area} * double{openness[slot]};
    result.mean += counted * sums[slot].x / sums[slot].w;
    result.counted += counted;
    result.area += texels[slot].area;
    ++result.texels;
  }
  result.mean /= result.counted;
  return result;
}

}  // namespace

TEST_CASE("texels half under a slab have the light of their open half") {
  const Crossed plain = light_of_crossed(0), open = light_of_crossed(2);
  MESSAGE("all parts alike: ", plain.mean, ", by openness: ", open.mean, ", counted: ", open.counted / open.area,
          ", texels: ", open.texels);
  REQUIRE(open.texels > 4);
  // The floor has 1 where it is open and 0 under the slab, hence a texel its open share.
  CHECK(plain.mean == test::relative(open.counted / open.area, 0.1));
  // Parts of a quarter texel's width that the side crosses are between: (n + f^2) / (n + f) of n whole ones and f of
  // one.
  CHECK(open.mean > 0.93);
  CHECK(open.mean < 1.0001);
  CHECK(plain.mean < 0.8);
}
