// SPDX-License-Identifier: Apache-2.0
// The paper's transfer, in which texels look themselves up in the bundle image: closed forms, and the other transfer's
// result.
#include <doctest/doctest.h>

#include <cmath>

#include "bundle_rig.h"
#include "lucarium/base/numbers.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::bundle;

namespace {

Parameters by_texels() {
  Parameters parameters;
  parameters.transfer = Transfer::texel;
  parameters.access_gap = 0;  // all parts of texels count alike
  return parameters;
}

}  // namespace

TEST_CASE("texels of a closed box of radiance 1 receive exactly that, and pi in sum") {
  Scene scene;
  const int white = add_lambert(scene, "white", glm::vec3(0.8f));
  test::BundleRig rig(test::box_scene({white, white, white, white, white, white}, std::move(scene)), 384, 0.5f, {},
                      by_texels());
  rig.send([](uint32_t) { return glm::vec3(1); });
  const int count = 256;
  Parameters parameters;
  parameters.block = count;
  rig.run(make_sequence(parameters, 7), count);
  double worst = 0, sum = 0;
  for (const glm::dvec4& v : rig.sums()) {
    if (!(v.w > 0)) FAIL("a texel has received nothing");
    worst = std::max(worst, std::abs(v.x / v.w - 1.0));
    sum += v.x / count;
  }
  // A point at a silhouette may be near no pixel centre within its surface: it then sees past the box.
  CHECK(worst < 0.02);
  CHECK(sum / rig.sides() == test::relative(pi, 2e-3));  // Σ W cos
}

TEST_CASE("form factors of unit squares by texels") {
  for (const bool parallel : {true, false}) {
    CAPTURE(parallel);
    Scene scene;
    const int white = add_lambert(scene, "white", glm::vec3(0.5f));
    add_instance(scene, add_mesh(scene, MeshBuilder("floor").box_face({0, 0, 0}, {1, 1, 1}, 1, 0, true).take()), white);
    add_instance(
        scene,
        add_mesh(scene, MeshBuilder("other").box_face({0, 0, 0}, {1, 1, 1}, parallel ? 1 : 0, parallel, true).take()),
        white);
    test::BundleRig rig(std::move(scene), 512, 0.5f, {}, by_texels());
    const std::vector<AtlasTexel> texels = rig.texels();
    std::vector<bool> lamp;
    for (const AtlasTexel& texel : texels) lamp.push_back(rig.instance_of(texel.triangle) == 0);
    rig.send([&](uint32_t side) { return glm::vec3(lamp[side] ? 1.f : 0.f); });
    rig.run(make_sequence(by_texels(), 7), 2048);
    const std::vector<glm::dvec4> sums = rig.sums();
    double received = 0, weight = 0;
    for (uint32_t side = 0; side < rig.sides(); ++side) {
      if (lamp[side]) continue;
      received += texels[side].area * sums[side].x;
      weight += texels[side].area * sums[side].w;
    }
    CHECK(std::abs(received / weight - (parallel ? 0.19982 : 0.20004)) < 2e-3);
  }
}

TEST_CASE("both transfers fill a furnace alike, and see the sides of a double-sided plate") {
  Scene scene;
  const int wall = add_lambert(scene, "wall", glm::vec3(0.5f));
  scene = test::box_scene({wall, wall, wall, wall, wall, wall}, std::move(scene));
  const int plate = add_lambert(scene, "plate", glm::vec3(0.5f));
  scene.materials[plate].double_sided = true;
  add_instance(
      scene,
      add_mesh(scene,
               MeshBuilder("plate").quad({.2f, .5f, .2f}, {.2f, .5f, .8f}, {.8f, .5f, .8f}, {.8f, .5f, .2f}).take()),
      plate);
  Parameters parameters = by_texels();
  test::BundleRig rig(scene, 512, 0.5f, {}, parameters);
  rig.set_direct(static_cast<float>(pi));
  rig.solve(make_sequence(parameters, 1), 512);
  CHECK(rig.mean(rig.indirect()) == test::relative(1, 0.002));  // 1 = 0.5 (1 + 1)
}

TEST_CASE("texels of a double-sided plate look into the sky on their side: 5 pi / 3 above, pi / 3 below") {
  Scene scene;
  const int white = add_lambert(scene, "white", glm::vec3(0.5f));
  scene.materials[white].double_sided = true;
  add_instance(scene, add_mesh(scene, MeshBuilder("plate").quad({0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 0, 0}).take()),
               white);
  Environment sky;
  sky.width = 256, sky.height = 128;
  for (uint32_t j = 0; j < sky.height; ++j)
    sky.radiance.insert(sky.radiance.end(), sky.width,
                        glm::vec3(static_cast<float>(1 + std::cos(pi * (j + 0.5) / sky.height))));
  scene.environment = sky;
  for (const bool emission : {true, false}) {  // without it, the sky's light comes by light samples alone
    CAPTURE(emission);
    Channels channels;
    channels.emission = emission;
    test::BundleRig rig(scene, 128, 0.5f, channels, by_texels());
    rig.send([](uint32_t) { return glm::vec3(0); });
    rig.run(make_sequence(by_texels(), 3), 512);
    const std::vector<SurfacePoint> points = rig.points();
    double received[2] = {}, weight[2] = {};
    for (uint32_t side = 0; side < rig.sides(); ++side) {
      received[points[side].normal.y > 0] += rig.sums()[side].x;
      weight[points[side].normal.y > 0] += rig.sums()[side].w;
    }
    for (const int up : {0, 1})
      CHECK(received[up] / weight[up] == test::relative(emission ? (up ? 5. / 3 : 1. / 3) : 0., 0.005));
  }
}
