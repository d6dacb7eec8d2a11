// SPDX-License-Identifier: Apache-2.0
// The environment through empty micro-pixels (gather_env).
#include <doctest/doctest.h>

#include "technique_fixture.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// A ball over a floor under a sky that is bright on one side.
Scene ball_under_sky(int ball_material_metal) {
  Scene scene;
  scene.source = "test:sky";
  add_instance(scene, add_mesh(scene, MeshBuilder("floor").quad({-4, 0, 4}, {4, 0, 4}, {4, 0, -4}, {-4, 0, -4}).take()),
               add_lambert(scene, "floor", glm::vec3(0.6f)));
  MeshBuilder ball("ball");
  for (const auto& t : icosphere(3)) {
    uint32_t v[3];
    for (size_t k = 0; k < 3; ++k) v[k] = ball.vertex(t[k] + glm::vec3(0, 1.3f, 0), t[k]);
    ball.face(v[0], v[1], v[2]);
  }
  const int material = ball_material_metal ? add_metal(scene, "metal", glm::vec3(0.9f), 0.6f)
                                           : add_lambert(scene, "ball", glm::vec3(0.6f));
  add_instance(scene, add_mesh(scene, ball.take()), material);
  Environment sky;
  sky.width = 8, sky.height = 4;
  for (int i = 0; i < 32; ++i)
    sky.radiance.push_back(glm::vec3(0.2f + 0.3f * static_cast<float>(i % 8)) * glm::vec3(1, 0.9f, 0.8f));
  scene.environment = sky;
  scene.cameras.push_back(look_at_camera("above", {0.5f, 4, 6}, {0, 0.7f, 0}, 40));
  return scene;
}

}  // namespace

TEST_CASE("the environment through empty micro-pixels is what light samples find") {
  for (const int metal : {0, 1}) {
    CAPTURE(metal);
    const Scene scene = ball_under_sky(metal);
    const auto direct = [&](const char* gathered, const char* step) {
      return rendered_layer(
          scene, "micro_rendering", "direct", 32, 1, 8,
          with(small,
               {{"gather_env", gathered}, {"gather_step", step}, {"direct_samples", "64"}, {"points_log2", "15"}}));
    };
    const std::vector<float> sampled = direct("off", "1"), gathered = direct("on", "1"),
                             interpolated = direct("on", "2");
    MESSAGE("RMSE over the mean: ", relative_rmse(gathered, sampled), ", interpolated ",
            relative_rmse(interpolated, sampled));
    CHECK(std::abs(mean(gathered) / mean(sampled) - 1) < 0.02);
    CHECK(relative_rmse(gathered, sampled) < 0.02);
    CHECK(std::abs(mean(interpolated) / mean(sampled) - 1) < 0.03);
  }
}

TEST_CASE("no sky leaks into a closed room") {
  Scene scene = load_scene("builtin:room");
  Environment sky;
  sky.factor = glm::vec3(1000);
  scene.environment = sky;
  const std::vector<float> with_sky =
      rendered_layer(scene, "micro_rendering", "direct", 32, 1, 4, with(small, {{"gather_env", "on"}}));
  scene.environment.reset();
  const std::vector<float> without =
      rendered_layer(scene, "micro_rendering", "direct", 32, 1, 4, with(small, {{"gather_env", "on"}}));
  MESSAGE("leak of a sky of 1000 cd/m²: ", mean(with_sky) - mean(without));
  CHECK(std::abs(mean(with_sky) - mean(without)) < 1e-3 * 1000);
}
