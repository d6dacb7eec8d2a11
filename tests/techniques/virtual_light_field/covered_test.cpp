// SPDX-License-Identifier: Apache-2.0
// Texels of a floor that lie partly under glass: a sheet of index 1, which nobody sees, hovers above it. It blocks
// light samples, and what they miss comes through it along the lines of the field: together as much as without the
// sheet.
#include <doctest/doctest.h>

#include <cmath>

#include "field_rig.h"
#include "lucarium/scene/builtin/builder.h"
#include "technique_session.h"
#include "tolerance.h"

using namespace lucarium;
using test::Options;
using test::relative;
using test::with;

namespace {

constexpr float height = 0.05f;  // of the sheet above the floor [m]: half an edge of a texel
constexpr float half_sheet = 0.5f, half_floor = 1.6f, albedo = 0.5f;

/// `turned`: the sheet about the vertical [rad].
Scene invisible_sheet(float turned = 0) {
  Scene scene;
  scene.environment = Environment{};
  scene.environment->factor = glm::vec3(1);
  const auto add_square = [&](float half, float y, float angle, const SceneMaterial& material) {
    const glm::vec3 x = half * glm::vec3(std::cos(angle), 0, std::sin(angle)), z(-x.z, 0, x.x), up(0, y, 0);
    test::add_polygon(scene, {up - x + z, up + x + z, up + x - z, up - x - z}, test::add_material(scene, material));
  };
  add_square(half_floor, 0, 0, test::lambert(albedo));
  SceneMaterial sheet;
  sheet.metallic = 0;
  sheet.roughness = 0;
  sheet.ior = 1;
  sheet.transmission = 1;
  sheet.double_sided = true;
  add_square(half_sheet, height, turned, sheet);
  // From just below the sheet: 24 pixels of 10 cm.
  SceneCamera camera;
  camera.name = "below";
  camera.perspective = false;
  camera.xmag = camera.ymag = 1.2f;
  camera.world_from_camera = frame_along({0, 0.5f * height, 0}, {0, -1, 0});
  scene.cameras.push_back(camera);
  return scene;
}

/// Mean over the rings of pixels on the inner and on the outer side of the sheet's edge, over what is right.
struct Rings {
  double inside = 0, outside = 0;
};
Rings rings(const std::vector<float>& image) {
  Rings sum, count;
  for (int y = 0; y < 24; ++y) {
    for (int x = 0; x < 24; ++x) {
      // The edge is 5 pixels from the middle.
      const int ring = std::max(std::max(x - 12, 11 - x), std::max(y - 12, 11 - y));
      const auto value = static_cast<double>(image[3 * (24 * static_cast<size_t>(y) + static_cast<size_t>(x))]);
      if (ring == 4) sum.inside += value / static_cast<double>(albedo), ++count.inside;
      if (ring == 5) sum.outside += value / static_cast<double>(albedo), ++count.outside;
    }
  }
  return {sum.inside / count.inside, sum.outside / count.outside};
}

const Options few_lines = {{"dir_n", "8"}, {"cells", "64"}, {"texels", "1200"}, {"preview", "off"}};

}  // namespace

TEST_CASE("a sheet that nobody sees takes no light from texels that lie partly under it, and gives them none") {
  for (const Options& eye : {Options{{"camera_samples", "256"}}, Options{{"preset", "walkthrough"}}}) {
    Rings mean;
    constexpr uint64_t seeds = 4;
    for (uint64_t seed = 1; seed <= seeds; ++seed) {
      const auto run = test::session("virtual_light_field", invisible_sheet(), {.seed = seed, .max_bounces = -1},
                                     with(eye, few_lines));
      run->run({.iterations = 2000});
      const Rings one = rings(run->resolve().image());
      mean.inside += one.inside / seeds;
      mean.outside += one.outside / seeds;
    }
    const std::string eyes = eye.front().first + "=" + eye.front().second;
    CAPTURE(eyes);
    MESSAGE(eyes << ": inside " << mean.inside << ", outside " << mean.outside);
    CHECK(mean.inside == relative(1, 0.05));
    CHECK(mean.outside == relative(1, 0.05));
  }
}

TEST_CASE("halves without a light sample get the light of one sky, not of two or none") {
  vlf::Parameters parameters;
  parameters.dir_n = 8;
  parameters.cells = 64;
  parameters.texels = 1200;
  test::FieldRig rig(invisible_sheet(0.6f), parameters);
  rig.propagate();
  const std::vector<AtlasTexel> texels = rig.surfaces().atlas.texels().download();
  const std::vector<float> shares = rig.surfaces().accessibility.shares().download();
  const std::vector<float4> samples = rig.surfaces().light.light_samples().download();
  const std::vector<uint32_t> instances = rig.instances();
  const std::vector<double> direct = rig.direct(), all = rig.all();
  for (const size_t first : {size_t{0}, texels.size()}) {
    double area = 0, of_direct = 0, sum = 0;
    for (size_t side = 0; side < texels.size(); ++side) {
      const size_t half = first + side;
      if (instances[side] != 0 || samples[half].w > 0) continue;
      const auto own = static_cast<double>(texels[side].area * shares[half]);
      area += own;
      of_direct += own * direct[half];
      sum += own * all[half];
    }
    const std::string which = first == 0 ? "open" : "covered";
    CAPTURE(which);
    REQUIRE(area > 0);
    MESSAGE(which << ": " << area << " m2, direct " << of_direct / area << ", all " << sum / area);
    CHECK(sum / area == relative(1, 0.05));
  }
}

TEST_CASE("covered halves of texel sides have the area of the glass above them") {
  vlf::Parameters parameters;
  parameters.dir_n = 4;
  parameters.cells = 32;
  parameters.texels = 1200;
  const test::FieldRig rig(invisible_sheet(), parameters);
  const vlf::FieldSurfaces& surfaces = rig.surfaces();
  REQUIRE(surfaces.accessibility.halves() == 2);
  const std::vector<AtlasTexel> texels = surfaces.atlas.texels().download();
  const std::vector<float> shares = surfaces.accessibility.shares().download();
  const std::vector<uint32_t> instances = rig.instances();
  double covered = 0, all = 0;
  for (size_t side = 0; side < texels.size(); ++side) {
    if (instances[side] != 0) continue;
    const auto area = static_cast<double>(texels[side].area);
    covered += area * static_cast<double>(shares[texels.size() + side]);
    all += area * static_cast<double>(shares[side] + shares[texels.size() + side]);
  }
  MESSAGE("covered " << covered << " m2 of " << all);
  CHECK(covered == relative(4 * half_sheet * half_sheet, 0.05));
  CHECK(all == relative(4 * half_floor * half_floor, 1e-3));

  // Nothing is kept twice without glass, and with the weights of the paper.
  parameters.access_gap = 0;
  CHECK(test::FieldRig(invisible_sheet(), parameters).surfaces().accessibility.halves() == 1);
}
