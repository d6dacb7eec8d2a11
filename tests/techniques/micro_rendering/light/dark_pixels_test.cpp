// SPDX-License-Identifier: Apache-2.0
// Pixels beside something near, where a single leaf fills a large part of the micro-buffer.
#include <doctest/doctest.h>

#include "technique_fixture.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// A wall at z = 0 and a ledge of 0.3 m on it whose left side the sun lights, seen from 5 m. As much power as the sun's
/// is that of lamps behind the wall, so that a light sample misses the sun half of the time.
Scene ledge_in_the_sun() {
  Scene scene;
  scene.source = "test:ledge";
  const int white = add_lambert(scene, "white", glm::vec3(0.8f));
  add_instance(scene, add_mesh(scene, MeshBuilder("wall").box({-1, -1, -0.1f}, {1, 1, 0}).take()), white);
  add_instance(scene, add_mesh(scene, MeshBuilder("ledge").box({0, -0.9f, -0.05f}, {0.3f, 0.9f, 0.3f}).take()), white);
  SceneLight sun;
  sun.type = LightType::directional;
  sun.world_from_light = frame_along({0, 0, 0}, {1, 0, -0.1f});
  sun.intensity = glm::vec3(10);
  scene.lights.push_back(sun);
  for (int i = 0; i < 7; ++i) {
    SceneLight lamp;
    lamp.world_from_light = frame_along({0.2f * static_cast<float>(i) - 0.6f, 0, -0.3f}, {0, 0, -1});
    lamp.intensity = glm::vec3(0.8f);
    scene.lights.push_back(lamp);
  }
  scene.cameras.push_back(look_at_camera("before", {-0.1f, 0, 5}, {-0.1f, 0, 0}, 2.2f));
  return scene;
}

/// Pixels that show less than 0.3 of what is expected there.
int dark_pixels(const std::vector<float>& values, const std::vector<float>& expected) {
  int count = 0;
  for (size_t i = 0; i < values.size(); i += 3) count += values[i] < 0.3f * expected[i];
  return count;
}

}  // namespace

TEST_CASE("dark pixels dot silhouettes after two frames: a leaf beside a pixel gets more than one light sample") {
  // With one sample a frame a leaf misses both times, and stays black, one time in four.
  const Scene scene = ledge_in_the_sun();
  const std::vector<float> expected = indirect_light(scene, "path_tracing", 24, 1, 4, reference);
  CHECK(mean(expected) > 0.1);
  const auto dark = [&](uint32_t seed, const Parameters& more) {
    RenderSettings settings = settings_for(scene, 24, 1);
    settings.seed = seed;
    RenderSession session(Device::open(), scene, registry().find("micro_rendering"), settings,
                          with({{"points_log2", "13"}}, more));
    session.run({.iterations = 2});
    return dark_pixels(session.resolve().find("indirect")->pixels, expected);
  };
  int dark_with_one = 0;
  for (const uint32_t seed : {1u, 2u, 3u}) {
    CAPTURE(seed);
    dark_with_one += dark(seed, {{"light_samples", "1"}});
    CHECK(dark(seed, {}) == 0);
  }
  MESSAGE("dark with one sample: ", dark_with_one);
  CHECK(dark_with_one > 0);  // or the scene shows nothing
}
