// SPDX-License-Identifier: Apache-2.0
// Sheets between light and what is lit: glass that absorbs, panes that must not, and two-sided ones from their dark
// side.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "technique_fixture.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// A lit corner of a floor and a lamp that is seen, all of it through `slab` metres of glass of index 1 that leaves
/// `left` of light per metre; 0: a pane without an inside.
Scene behind_glass(float slab, const glm::vec3& left) {
  Scene scene;
  scene.source = "test:glass";
  const int white = add_lambert(scene, "white", glm::vec3(0.8f));
  add_instance(scene, add_mesh(scene, MeshBuilder("floor").quad({-1, 0, 2}, {1, 0, 2}, {1, 0, 0}, {-1, 0, 0}).take()),
               white);
  add_instance(scene, add_mesh(scene, MeshBuilder("wall").quad({-1, 0, 0}, {1, 0, 0}, {1, 2, 0}, {-1, 2, 0}).take()),
               white);
  add_instance(
      scene,
      add_mesh(scene, MeshBuilder("lamp").quad({0.5f, 0, 1}, {0.8f, 0, 1}, {0.8f, 0.3f, 1}, {0.5f, 0.3f, 1}).take()),
      add_emitter(scene, "lamp", glm::vec3(1)));
  SceneMaterial glass;
  glass.base_color = glm::vec4(1);
  glass.metallic = 0, glass.roughness = 0, glass.transmission = 1, glass.ior = 1;
  glass.thickness = slab;
  glass.attenuation_distance = 1;
  glass.attenuation_color = left;
  scene.materials.push_back(glass);
  MeshBuilder builder("glass");
  if (slab > 0)
    builder.box({-2, -1, 4}, {2, 3, 4 + slab});
  else
    builder.quad({-2, -1, 4}, {2, -1, 4}, {2, 3, 4}, {-2, 3, 4});
  add_instance(scene, add_mesh(scene, builder.take()), static_cast<int>(scene.materials.size()) - 1);
  SceneLight light;
  light.world_from_light = frame_along({-0.3f, 1.2f, 0.8f}, {0, -1, 0});
  light.intensity = glm::vec3(2);
  scene.lights.push_back(light);
  scene.cameras.push_back(look_at_camera("before", {0, 0.8f, 8}, {0, 0.8f, 0}, 18));
  return scene;
}

}  // namespace

TEST_CASE("all layers through tinted glass lose what it absorbs, and nothing through a thin pane") {
  const glm::vec3 left(0.25f, 0.5f, 1);
  const Parameters parameters = with(small, {{"direct_samples", "1"}, {"light_samples", "1"}});
  for (const char* layer : {"emission", "direct", "indirect"}) {
    CAPTURE(std::string(layer));
    const auto render = [&](float slab, const glm::vec3& color) {
      return rendered_layer(behind_glass(slab, color), "micro_rendering", layer, 16, 1, 1, parameters);
    };
    const std::vector<float> clear = render(1, glm::vec3(1)), tinted = render(1, left), pane = render(0, glm::vec3(1)),
                             tinted_pane = render(0, left);
    CHECK(mean(clear) > 0);
    CHECK(tinted_pane == pane);
    // From the camera straight ahead: ways through the slab are longer by up to 1 / cos 12 degrees, 2.4 %.
    for (size_t i = 0; i < clear.size(); ++i) {
      CAPTURE(i);
      const double x = (static_cast<double>(i / 3 % 16) - 7.5) / 8, y = (static_cast<double>(i / 3 / 16) - 7.5) / 8,
                   t = std::tan(9 * std::numbers::pi / 180), way = std::sqrt(1 + t * t * (x * x + y * y));
      const double transmitted = std::pow(static_cast<double>(left[static_cast<int>(i % 3)]), way);
      CHECK(double{tinted[i]} == test::within(transmitted * double{clear[i]}, 1e-3 * double{clear[i]} + 1e-7));
    }
  }
}

TEST_CASE("a two-sided sheet lit from one side shines at what sees that side, and at nothing that sees the other") {
  // The sheet between two floors that face it; a spot lights its upper or its lower side. Nodes that hold points of
  // several of these layers left a tenth of each open, and 4 % of the light was missing.
  const auto light_of = [](bool lit_above, bool seen_above, const char* technique) {
    Scene scene;
    scene.source = "test:sheet";
    const int white = add_lambert(scene, "white", glm::vec3(0.8f)),
              sheet = add_lambert(scene, "sheet", {0.5f, 0.7f, 0.2f});
    scene.materials[sheet].double_sided = true;
    add_instance(scene,
                 add_mesh(scene, MeshBuilder("sheet").quad({-1, 1, 1}, {1, 1, 1}, {1, 1, -1}, {-1, 1, -1}).take()),
                 sheet);
    add_instance(scene,
                 add_mesh(scene, MeshBuilder("floor").quad({-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1}).take()),
                 white);
    add_instance(scene, add_mesh(scene, MeshBuilder("top").quad({-1, 2, -1}, {1, 2, -1}, {1, 2, 1}, {-1, 2, 1}).take()),
                 white);
    SceneLight light;
    light.type = LightType::spot;
    const glm::vec3 from(0, lit_above ? 1.9f : 0.1f, 0);
    light.world_from_light = frame_along(from, glm::vec3(0, 1, 0) - from);
    light.inner_angle = 0.3f, light.outer_angle = 0.4f;
    light.intensity = glm::vec3(20);
    scene.lights.push_back(light);
    scene.cameras.push_back(
        look_at_camera("between", {0, seen_above ? 1.2f : 0.8f, 3}, {0, seen_above ? 2.f : 0.f, 0}, 25));
    return indirect_light(scene, technique, 16, 1, std::string(technique) == "path_tracing" ? 16 : 4,
                          std::string(technique) == "path_tracing"
                              ? reference
                              : with(small, {{"points_log2", "16"}, {"micro_size", "24"}}));
  };
  for (const bool lit_above : {false, true}) {
    CAPTURE(lit_above);
    const std::vector<float> expected = light_of(lit_above, lit_above, "path_tracing"),
                             lit = light_of(lit_above, lit_above, "micro_rendering"),
                             dark = light_of(lit_above, !lit_above, "micro_rendering");
    CHECK(mean(expected) > 0.01);
    CHECK(mean(lit) == test::relative(mean(expected), 0.02));
    CHECK(mean(dark) < 0.01 * mean(lit));  // of the few nodes that hold points of both sides
  }
}
