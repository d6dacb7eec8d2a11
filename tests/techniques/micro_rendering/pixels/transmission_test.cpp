// SPDX-License-Identifier: Apache-2.0
// Rough transmission at the visible surface: gathers on its far side.
#include <doctest/doctest.h>

#include "technique_fixture.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// A frosted pane before a coloured corner that a lamp behind the pane shines at. Not thin: the pane is where a medium
/// begins.
Scene frosted_pane(bool thin, float roughness) {
  Scene scene;
  scene.source = "test:pane";
  SceneMaterial glass;
  glass.name = "frosted";
  glass.base_color = glm::vec4(0.9f, 0.8f, 0.7f, 1);
  glass.metallic = 0;
  glass.roughness = roughness;
  glass.transmission = 1;
  glass.ior = 1.5f;
  glass.thickness = thin ? 0.f : 1.f;
  scene.materials.push_back(glass);
  add_instance(scene, add_mesh(scene, MeshBuilder("pane").quad({-1, 0, 0}, {1, 0, 0}, {1, 2, 0}, {-1, 2, 0}).take()),
               static_cast<int>(scene.materials.size()) - 1);
  add_instance(scene, add_mesh(scene, MeshBuilder("floor").quad({-1, 0, 0}, {1, 0, 0}, {1, 0, -2}, {-1, 0, -2}).take()),
               add_lambert(scene, "floor", {0.8f, 0.3f, 0.2f}));
  add_instance(scene,
               add_mesh(scene, MeshBuilder("back").quad({-1, 0, -2}, {1, 0, -2}, {1, 2, -2}, {-1, 2, -2}).take()),
               add_lambert(scene, "back", {0.2f, 0.5f, 0.8f}));
  SceneLight light;
  light.world_from_light = frame_along({0.3f, 1.5f, -0.8f}, {0, -1, 0});
  light.intensity = glm::vec3(2);
  scene.lights.push_back(light);
  scene.cameras.push_back(look_at_camera("before", {0.4f, 1.2f, 2}, {0, 0.9f, 0}, 45));
  return scene;
}

}  // namespace

TEST_CASE("light through frosted glass and into a rough medium is the path tracer's") {
  for (const bool thin : {true, false})
    for (const float roughness : {0.4f, 0.7f}) {
      CAPTURE(thin);
      CAPTURE(roughness);
      const Scene scene = frosted_pane(thin, roughness);
      const std::vector<float> expected = indirect_light(scene, "path_tracing", 16, 1, 32, reference);
      for (const char* warp : {"analytic", "table"}) {
        CAPTURE(std::string(warp));
        const std::vector<float> mine =
            indirect_light(scene, "micro_rendering", 16, 1, 8,
                           with(small, {{"warp", warp}, {"points_log2", "16"}, {"micro_size", "24"}}));
        MESSAGE("mean ", mean(mine), " of ", mean(expected), ", RMSE over it ", relative_rmse(mine, expected));
        CHECK(std::abs(mean(mine) / mean(expected) - 1) < 0.02);
        CHECK(relative_rmse(mine, expected) < 0.03);
      }
    }
  // Between gathers nothing is interpolated through the pane.
  const Scene scene = frosted_pane(true, 0.4f);
  const std::vector<float> every = indirect_light(scene, "micro_rendering", 16, 1, 4, small),
                           second =
                               indirect_light(scene, "micro_rendering", 16, 1, 4, with(small, {{"gather_step", "2"}}));
  CHECK(relative_rmse(second, every) < 0.02);
}

TEST_CASE("what a rough surface reflects into the medium below it is the path tracer's") {
  // Beyond 42 degrees all of it, where the same surface reflects a twentieth from outside. Pixel by pixel the path
  // tracer's noise is 5 to 8 % here.
  for (const float roughness : {0.4f, 0.7f}) {
    CAPTURE(roughness);
    Scene scene = frosted_pane(false, roughness);
    scene.cameras.front() = look_at_camera("below", {-0.5f, 1.6f, -1.2f}, {0.2f, 0.9f, 0}, 45);
    const double expected = mean(indirect_light(scene, "path_tracing", 16, 1, 64, reference));
    for (const char* warp : {"analytic", "table"}) {
      CAPTURE(std::string(warp));
      const double mine =
          mean(indirect_light(scene, "micro_rendering", 16, 1, 8,
                              with(small, {{"warp", warp}, {"points_log2", "16"}, {"micro_size", "24"}})));
      CHECK(mine == test::relative(expected, 0.02));
    }
  }
}

TEST_CASE("a cut driven by the spread of light is the same in every run, on both sides of a pane") {
  const Scene scene = frosted_pane(true, 0.7f);
  const auto visits = [&] {
    RenderSession session(Device::open(), scene, registry().find("micro_rendering"), settings_for(scene, 16, 1),
                          with(small, {{"cut_error", "0.01"}}));
    session.run({.iterations = 3});
    return session.technique().counters().at("node visits");
  };
  const double first = visits();
  CHECK(first > 0);
  CHECK(visits() == first);
}
