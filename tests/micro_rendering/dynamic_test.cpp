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
    add_instance(scene, add_mesh(scene, MeshBuilder("lamp").quad({-0.5f, 2.8f, 1}, {0.5f, 2.8f, 1}, {0.5f, 2.8f, 2}, {-0.5f, 2.8f, 2}).take()),
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
          indirect_light(scene, "micro_rendering", 16, 1, 32, with(small, {{"node_shading", "dynamic"}, {"points_log2", "15"}, {"micro_size", "24"}}));
      const std::vector<float> stored = indirect_light(scene, "micro_rendering", 16, 1, 1, small);
      MESSAGE("RMSE over the mean ", relative_rmse(mine, expected));
      CHECK(mean(stored) < 0.5 * mean(expected));  // metals have no diffuse lobe
      for (size_t channel = 0; channel < 3; ++channel)
        CHECK(std::abs(channel_mean(mine, channel) / channel_mean(expected, channel) - 1) < 0.03);
      CHECK(relative_rmse(mine, expected) < 0.04);
    }
  }
}

TEST_CASE("virtual lights shine at glossy nodes too") {
  // Beyond one bounce the path set has no name; with one virtual light per path and a metal wall the light must exceed the
  // one-bounce part, and stay below that of the full path tracer, whose floor sees more than one glossy vertex.
  const Scene scene = metal_wall(0.6f, false);
  const Parameters lights = with(small, {{"node_shading", "dynamic"}, {"multibounce", "instant_radiosity"}, {"vpls", "64"}, {"points_log2", "11"}});
  const double one = mean(indirect_light(scene, "micro_rendering", 16, 1, 8, lights));
  const double two = mean(indirect_light(scene, "micro_rendering", 16, 2, 8, lights));
  const double bound = mean(indirect_light(scene, "path_tracing", 16, 2, 16, {{"light_delta", "off"}, {"samples_per_iteration", "64"}}));
  MESSAGE("one bounce ", one, ", two ", two, ", path tracer ", bound);
  CHECK(two > 1.02 * one);
  CHECK(two < 1.03 * bound);
}
