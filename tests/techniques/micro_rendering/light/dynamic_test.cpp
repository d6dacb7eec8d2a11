// SPDX-License-Identifier: Apache-2.0
// Glossy lobes of nodes (node_shading=dynamic): paths L {S|D} {S|D} E.
#include <doctest/doctest.h>

#include "technique_fixture.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// A white floor before a metal wall that a lamp shines at: what the floor gets is the wall's glossy light alone.
Scene metal_wall(float roughness, bool area_light) {
  Scene scene;
  scene.source = "test:metal wall";
  add_instance(scene, add_mesh(scene, MeshBuilder("floor").quad({-1, 0, 2}, {1, 0, 2}, {1, 0, 0}, {-1, 0, 0}).take()),
               add_lambert(scene, "white", glm::vec3(0.8f)));
  add_instance(scene, add_mesh(scene, MeshBuilder("wall").quad({-1, 0, 0}, {1, 0, 0}, {1, 2, 0}, {-1, 2, 0}).take()),
               add_metal(scene, "metal", {0.9f, 0.6f, 0.3f}, roughness));
  if (area_light) {
    add_instance(
        scene,
        add_mesh(scene,
                 MeshBuilder("lamp").quad({-0.5f, 2.8f, 1}, {0.5f, 2.8f, 1}, {0.5f, 2.8f, 2}, {-0.5f, 2.8f, 2}).take()),
        add_emitter(scene, "lamp", glm::vec3(5)));
  } else {
    SceneLight light;
    light.world_from_light = frame_along({0.3f, 1.5f, 1.5f}, {0, -1, 0});
    light.intensity = glm::vec3(5, 5, 2);
    scene.lights.push_back(light);
    light.world_from_light = frame_along({-0.5f, 0.7f, 1.2f}, {0, -1, 0});
    light.intensity = glm::vec3(1, 2, 4);
    scene.lights.push_back(light);
  }
  scene.cameras.push_back(look_at_camera("above", {0, 2.5f, 1.6f}, {0, 0, 0.8f}, 35));
  return scene;
}

double channel_mean(const std::vector<float>& image, size_t channel) {
  double sum = 0;
  for (size_t i = channel; i < image.size(); i += 3) sum += static_cast<double>(image[i]);
  return sum / static_cast<double>(image.size() / 3);
}

}  // namespace

TEST_CASE("glossy nodes send light where the path tracer's full BSDF does") {
  const Parameters full = {{"light_delta", "off"}, {"samples_per_iteration", "64"}};
  for (const bool area_light : {false, true}) {
    for (const float roughness : {0.5f, 0.8f}) {
      CAPTURE(area_light);
      CAPTURE(roughness);
      const Scene scene = metal_wall(roughness, area_light);
      const std::vector<float> expected = indirect_light(scene, "path_tracing", 16, 1, 128, full);
      const std::vector<float> mine =
          indirect_light(scene, "micro_rendering", 16, 1, 32,
                         with(small, {{"node_shading", "dynamic"}, {"points_log2", "15"}, {"micro_size", "24"}}));
      const std::vector<float> stored = indirect_light(scene, "micro_rendering", 16, 1, 1, small);
      MESSAGE("RMSE over the mean ", relative_rmse(mine, expected));
      CHECK(mean(stored) < 0.5 * mean(expected));  // metals have no diffuse lobe
      for (size_t channel = 0; channel < 3; ++channel)
        CHECK(std::abs(channel_mean(mine, channel) / channel_mean(expected, channel) - 1) < 0.03);
      CHECK(relative_rmse(mine, expected) < 0.04);
    }
  }
}

TEST_CASE("virtual lights shine at glossy nodes too: the only way to the floor is the path tracer's") {
  // A spot light shines at a white patch, which sees a metal wall but not the floor: that lies behind its plane. The
  // wall gets no direct light: all that the floor gets in two bounces comes over the patch (virtual lights) and the
  // wall's glossy lobe.
  Scene scene;
  scene.source = "test:patch, metal wall";
  const int white = add_lambert(scene, "white", glm::vec3(0.8f));
  add_instance(scene, add_mesh(scene, MeshBuilder("floor").quad({-1, 0, 2}, {1, 0, 2}, {1, 0, 0}, {-1, 0, 0}).take()),
               white);
  add_instance(scene, add_mesh(scene, MeshBuilder("wall").quad({-1, 0, 0}, {1, 0, 0}, {1, 4, 0}, {-1, 4, 0}).take()),
               add_metal(scene, "metal", {0.9f, 0.6f, 0.3f}, 0.7f));
  const glm::vec3 centre(0, 3, 3), n = glm::normalize(glm::vec3(0, 2, -1)), t(1.8f, 0, 0),
                                   b = 1.8f * glm::cross(n, glm::vec3(1, 0, 0));
  add_instance(
      scene,
      add_mesh(scene, MeshBuilder("patch").quad(centre - t - b, centre + t - b, centre + t + b, centre - t + b).take()),
      white);
  SceneLight light;
  light.type = LightType::spot;
  light.world_from_light = frame_along(centre + 4.f * n, -n);
  light.inner_angle = 0.35f;
  light.outer_angle = 0.4f;  // a radius of 1.7 m on the patch
  light.intensity = glm::vec3(40);
  scene.lights.push_back(light);
  scene.cameras.push_back(look_at_camera("above", {0, 1.5f, 1.2f}, {0, 0, 0.8f}, 45));
  const Parameters lights =
      with(small, {{"node_shading", "dynamic"}, {"multibounce", "instant_radiosity"}, {"vpls", "64"}});
  CHECK(mean(indirect_light(scene, "micro_rendering", 16, 1, 2, lights)) == 0);
  const std::vector<float> mine = indirect_light(scene, "micro_rendering", 16, 2, 16, lights);
  const std::vector<float> expected =
      indirect_light(scene, "path_tracing", 16, 2, 64, {{"light_delta", "off"}, {"samples_per_iteration", "64"}});
  MESSAGE("mean ", mean(mine), " of ", mean(expected), ", RMSE over it ", relative_rmse(mine, expected));
  for (size_t channel = 0; channel < 3; ++channel)
    CHECK(std::abs(channel_mean(mine, channel) / channel_mean(expected, channel) - 1) < 0.03);
}
