// SPDX-License-Identifier: Apache-2.0
// What pixels gather: limits of bounces along chains, and rays of points that the bundle image does not hold.
#include <doctest/doctest.h>

#include <cmath>

#include "made_scene.h"
#include "technique_rig.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

SceneMaterial metal(float reflectance, float roughness) {
  SceneMaterial material = lambert(reflectance);
  material.metallic = 1;
  material.roughness = roughness;
  return material;
}

void look(Scene& scene, const glm::vec3& eye, const glm::vec3& target, const glm::vec3& up, float yfov) {
  SceneCamera camera;
  camera.yfov = yfov;
  camera.world_from_camera = glm::inverse(glm::lookAt(eye, target, up));
  scene.cameras.push_back(camera);
}

/// A closed box of metal with a lamp all over its ceiling. `floor`: its floor is white.
Scene metal_box(bool white_floor) {
  Scene scene;
  const int wall = add_material(scene, metal(0.8f, 0.6f)), lamp = add_material(scene, emitter(1));
  test::add_box(scene, {0, 0, 0}, {1, 1, 1}, true, wall);
  add_horizontal(scene, 0.5f, 0.95f, 0.5f, 0.95f, 0.95f, false, lamp);
  if (white_floor) add_horizontal(scene, 0.5f, 0.05f, 0.5f, 0.95f, 0.95f, true, add_material(scene, lambert(0.8f)));
  look(scene, {0.5f, 0.5f, 0.95f}, {0.5f, 0.4f, 0}, {0, 1, 0}, 1.2f);
  return scene;
}

double layer_mean(const std::string& technique, Scene scene, int max_bounces, uint64_t iterations,
                  const Options& options, const char* layer) {
  const auto run = session(technique, std::move(scene), max_bounces, options);
  run->run({.iterations = iterations});
  return mean(run->resolve().find(layer)->pixels);
}

/// A comb of white slats, thinner than pixels of the bundle image, under a sky of radiance 1 + w_y, seen from above.
Scene slats() {
  Scene scene;
  const int white = add_material(scene, lambert(0.5f));
  for (int i = 0; i < 16; ++i) {
    const float x = -0.8f + 0.1f * static_cast<float>(i);
    add_polygon(scene, {{x, 0, -1}, {x, 0, 1}, {x + 0.025f, 0, 1}, {x + 0.025f, 0, -1}}, white);
  }
  Environment sky;
  sky.width = 64, sky.height = 32;
  for (uint32_t j = 0; j < sky.height; ++j)
    sky.radiance.insert(
        sky.radiance.end(), sky.width,
        glm::vec3(1 + std::cos(3.14159265f * (static_cast<float>(j) + 0.5f) / static_cast<float>(sky.height))));
  scene.environment = sky;
  look(scene, {0, 3, 0}, {0, 0, 0}, {0, 0, -1}, 0.5f);
  return scene;
}

}  // namespace

TEST_CASE("without indirect light chains of pixels end at their first vertex") {
  CHECK(layer_mean("bundle_exchange", metal_box(false), 0, 4, few_texels, "direct") > 0.01);
  CHECK(layer_mean("bundle_exchange", metal_box(false), 0, 4, few_texels, "indirect") == 0);
}

TEST_CASE("chains of pixels have as many scatterings as are asked for, those of the texels at their ends included") {
  const Options paths = {{"samples_per_iteration", "64"}};
  const double expected = layer_mean("path_tracing", metal_box(true), 1, 16, paths, "indirect");
  const double found = layer_mean("bundle_exchange", metal_box(true), 1, 96, few_texels, "indirect");
  MESSAGE("indirect light ", found, ", path traced ", expected);
  CHECK(found == test::relative(expected, 0.03));
}

TEST_CASE("pixels whose points the bundle image does not hold gather by rays of their own") {
  const Options bundles = {{"texels", "64"},           {"pixel_size", "2"},     {"batch", "1"},
                           {"stop_error", "0"},        {"final_gather", "all"}, {"pixel_rays", "bundle"},
                           {"direct_mode", "exchange"}};
  const double expected = layer_mean("path_tracing", slats(), 1, 4, {{"samples_per_iteration", "64"}}, "direct");
  const double found = layer_mean("bundle_exchange", slats(), 1, 64, bundles, "direct");
  MESSAGE("direct light ", found, ", path traced ", expected);
  CHECK(expected > 0.05);
  CHECK(found == test::relative(expected, 0.05));
}
