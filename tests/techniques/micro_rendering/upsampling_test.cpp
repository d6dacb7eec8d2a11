// SPDX-License-Identifier: Apache-2.0
// Pixels between gathers.
#include <doctest/doctest.h>

#include "technique_fixture.h"

using namespace lucarium;
using namespace lucarium::test;

TEST_CASE("between gathers light falls off as it does with a gather at every pixel: weights fall with the distance") {
  // A floor before a lit wall, from above: 16 pixels of which the light falls off to a third.
  Scene scene;
  scene.source = "test:slope";
  const int white = add_lambert(scene, "white", glm::vec3(0.8f));
  add_instance(scene, add_mesh(scene, MeshBuilder("floor").quad({-1, 0, 2}, {1, 0, 2}, {1, 0, 0}, {-1, 0, 0}).take()),
               white);
  add_instance(scene, add_mesh(scene, MeshBuilder("wall").quad({-1, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 1, 0}).take()),
               white);
  SceneLight light;
  light.type = LightType::directional;
  light.world_from_light = frame_along({0, 0, 0}, {0, 0, -1});
  light.intensity = glm::vec3(10);
  scene.lights.push_back(light);
  SceneCamera camera = look_at_camera("above", {0, 10, 0.8f}, {0, 0, 0.8f}, 6.8f);
  scene.cameras.push_back(camera);
  const auto render = [&](const char* step) {
    return indirect_light(scene, "micro_rendering", 17, 1, 1, {{"points_log2", "13"}, {"gather_step", step}});
  };
  const std::vector<float> every = render("1"), fourth = render("4");
  const double error = relative_rmse(fourth, every);
  MESSAGE("RMSE over the mean: ", error);
  CHECK(every[3 * (17 + 8)] > 2 * every[3 * (17 * 15 + 8)]);
  CHECK(error < 0.06);
}
