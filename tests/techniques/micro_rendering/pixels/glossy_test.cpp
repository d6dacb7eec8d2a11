// SPDX-License-Identifier: Apache-2.0
// Glossy lobes of visible surfaces.
#include <doctest/doctest.h>

#include "technique_fixture.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

TEST_CASE("a glossy floor in grazing view reflects a lit wall as the path tracer's does") {
  // A metal of F0 = 1/2, seen at 80 to 85 degrees: Fresnel's rise towards the horizon is a quarter of the light.
  Scene scene;
  scene.source = "test:glossy floor";
  add_instance(scene, add_mesh(scene, MeshBuilder("floor").quad({-1, 0, 2}, {1, 0, 2}, {1, 0, 0}, {-1, 0, 0}).take()),
               add_metal(scene, "metal", glm::vec3(0.5f), 0.5f));
  add_instance(scene, add_mesh(scene, MeshBuilder("wall").quad({-2, 0, 0}, {2, 0, 0}, {2, 3, 0}, {-2, 3, 0}).take()),
               add_lambert(scene, "white", glm::vec3(0.8f)));
  SceneLight light;
  light.type = LightType::directional;
  light.world_from_light = frame_along(glm::vec3(0), {0, 0, -1});
  light.intensity = glm::vec3(3);
  scene.lights.push_back(light);
  scene.cameras.push_back(look_at_camera("grazing", {0, 0.5f, 4}, {0, 0, 1}, 6));
  const std::vector<float> expected = indirect_light(scene, "path_tracing", 16, 1, 64, reference),
                           mine = indirect_light(scene, "micro_rendering", 16, 1, 8,
                                                 with(small, {{"points_log2", "14"}, {"micro_size", "24"}}));
  MESSAGE("mean ", mean(mine) / mean(expected), " of the reference, RMSE over it ", relative_rmse(mine, expected));
  CHECK(mean(expected) > 0.01);
  CHECK(mean(mine) == test::relative(mean(expected), 0.02));
}
