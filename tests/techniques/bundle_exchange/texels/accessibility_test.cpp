// SPDX-License-Identifier: Apache-2.0
// A texel that is partly covered by something near is as bright as its visible part.
#include <doctest/doctest.h>

#include "bundle_rig.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::bundle;

namespace {

constexpr float kEdge = 0.53f;  // x (or z) of the slab's side, within texels of the floor

/// A floor of a square metre under a sky of radiance 1 (or 1 + w_y), and just above it a slab that covers all x < kEdge
/// (or z).
Scene floor_and_slab(bool along_z = false, bool even = true) {
  Scene scene;
  const int white = add_lambert(scene, "white", glm::vec3(0.5f));
  add_instance(scene, add_mesh(scene, MeshBuilder("floor").box_face({0, 0, 0}, {1, 1, 1}, 1, 0, true).take()), white);
  const glm::vec3 low(-0.5f, 0.001f, -0.5f),
      high = along_z ? glm::vec3(1.5f, 0.002f, kEdge) : glm::vec3(kEdge, 0.002f, 1.5f);
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side)
      add_instance(scene, add_mesh(scene, MeshBuilder("slab").box_face(low, high, axis, side, false).take()), white);
  Environment sky;
  sky.width = 64, sky.height = 32;
  for (uint32_t j = 0; j < sky.height; ++j)
    sky.radiance.insert(
        sky.radiance.end(), sky.width,
        glm::vec3(even ? 1.f
                       : 1 + std::cos(3.14159265f * (static_cast<float>(j) + 0.5f) / static_cast<float>(sky.height))));
  scene.environment = sky;
  return scene;
}

/// Of the floor's texels that the slab's side crosses: irradiance over π, by what each counts; and their number.
struct Crossed {
  double mean = 0, counted = 0, area = 0, sampled = 0;
  int texels = 0;
};
Crossed light_of_crossed(const Scene& scene, float access_gap, bool along_z = false, uint32_t light_samples = 0) {
  Channels channels;
  channels.emission = true;
  Parameters parameters;
  parameters.access_gap = access_gap;
  test::BundleRig rig(scene, 320, 0.5f, channels, parameters);
  rig.send([](uint32_t) { return glm::vec3(0); });
  rig.run(make_sequence(parameters, 3), 512);
  const std::vector<glm::dvec4> sums = rig.sums();
  const std::vector<float> accessibility = rig.accessibility();
  const std::vector<AtlasTexel> texels = rig.texels();
  const std::vector<SurfacePoint> points = rig.points();
  const std::vector<double> sampled =
      light_samples > 0 ? rig.sampled_light(light_samples) : std::vector<double>(rig.sides());
  Crossed result;
  for (uint32_t side = 0; side < rig.sides(); ++side) {
    if (rig.instance_of(texels[side].triangle) != 0) continue;
    const double edge = std::sqrt(double{texels[side].area}),
                 across = along_z ? points[side].position.z : points[side].position.x;
    if (std::abs(across - double{kEdge}) > 0.3 * edge) continue;
    const double counted = double{texels[side].area} * double{accessibility[side]};
    result.mean += counted * sums[side].x / sums[side].w;
    result.sampled += counted * sampled[side];
    result.counted += counted;
    result.area += texels[side].area;
    ++result.texels;
  }
  result.mean /= result.counted;
  result.sampled /= result.counted;
  return result;
}

}  // namespace

TEST_CASE("texels half under a slab have the light of their open half") {
  for (const bool along_z : {false, true}) {
    CAPTURE(along_z);
    const Scene scene = floor_and_slab(along_z);
    const Crossed plain = light_of_crossed(scene, 0, along_z), open = light_of_crossed(scene, 2, along_z);
    MESSAGE("all parts alike: ", plain.mean, ", by accessibility: ", open.mean, ", counted: ", open.counted / open.area,
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
}

TEST_CASE("texels half under a slab: light samples and bundles bring the same of an uneven sky") {
  const Crossed found = light_of_crossed(floor_and_slab(false, false), 2, false, 512);
  MESSAGE("by bundles ", found.mean, ", by light samples ", found.sampled, ", all open 5/3");
  CHECK(found.mean == test::relative(5. / 3, 0.07));
  CHECK(found.sampled == test::relative(found.mean, 0.02));
}

TEST_CASE("rays that soon meet a back say nothing of how accessible a place is") {
  // A floor, and above it for x < kEdge a lid that has no underside. Beside the lid all other rays go far.
  Scene scene;
  const int white = add_lambert(scene, "white", glm::vec3(0.5f));
  add_instance(scene, add_mesh(scene, MeshBuilder("floor").box_face({0, 0, 0}, {1, 1, 1}, 1, 0, true).take()), white);
  const float h = 0.05f;
  add_instance(
      scene,
      add_mesh(scene,
               MeshBuilder("lid").quad({-.5f, h, -.5f}, {-.5f, h, 1.5f}, {kEdge, h, 1.5f}, {kEdge, h, -.5f}).take()),
      white);
  Parameters parameters;
  parameters.access_gap = 2;
  test::BundleRig rig(scene, 300, 0.5f, {}, parameters);
  const std::vector<float> accessibility = rig.accessibility();
  const std::vector<AtlasTexel> texels = rig.texels();
  const std::vector<SurfacePoint> points = rig.points();
  int beside = 0;
  for (uint32_t side = 0; side < rig.sides(); ++side) {
    if (rig.instance_of(texels[side].triangle) != 0) continue;
    const double from_lid = double{points[side].position.x - kEdge} / rig.texel_edge();
    if (from_lid < 0.6 || from_lid > 1.4) continue;  // below the lid's edge no part of it
    CHECK(accessibility[side] == 1.f);
    ++beside;
  }
  MESSAGE(beside, " texels, the lid ", double{h} / rig.texel_edge(), " edges above them");
  CHECK(beside > 5);
}

TEST_CASE("the gap of accessibility grows with the scene, from two to eight edges of texels") {
  CHECK(SideAccessibility::automatic_gap(1, 0.02f) == test::relative(5, 1e-6));
  CHECK(SideAccessibility::automatic_gap(1, 0.2f) == 2);
  CHECK(SideAccessibility::automatic_gap(30, 0.02f) == 8);
  CHECK(SideAccessibility::automatic_gap(0, 0) == 2);
}
