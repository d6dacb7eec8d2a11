// SPDX-License-Identifier: Apache-2.0
// Scenes at the edge of what has a field, under a sky of radiance 1, where what the camera sees is known: looked up by
// rays and in tiles, with one bounce after another.
#include <doctest/doctest.h>

#include <string>

#include "field_rig.h"
#include "lucarium/base/error.h"
#include "lucarium/scene/builtin/builder.h"
#include "made_scene.h"
#include "technique_rig.h"
#include "tolerance.h"

using namespace lucarium;
using test::Options;
using test::within;

namespace {

const Options coarse = {{"dir_n", "3"}, {"cells", "24"}, {"texels", "512"}, {"camera_samples", "1"}};
const Options looked_up = test::with(coarse, {{"direct_mode", "exchange"}, {"preset", "walkthrough"}});
const Options papers = test::with(coarse, {{"preset", "paper"}, {"scatter", "splat"}});  // raw splats are uneven

/// A camera above y = 0 that looks down at the middle, and a white sky.
Scene under_sky() {
  Scene scene;
  Environment sky;
  sky.width = sky.height = 8;
  sky.radiance.assign(64, glm::vec3(1));
  scene.environment = sky;
  scene.cameras.push_back(look_at_camera("above", {0, 2, 0.1f}, {0, 0, 0}, 10.f));
  return scene;
}

/// Mean of the picture, when all light is there.
double seen(const Scene& scene, const Options& options) {
  const auto run = test::session(scene, -1, options);
  run->finish_light();
  run->run({.samples = 256});
  const std::vector<float> pixels = run->resolve().image();
  for (const float v : pixels) REQUIRE(std::isfinite(v));
  return test::mean(pixels);
}

void check(const Scene& scene, double expected, double tolerance) {
  for (const Options& options : {coarse, looked_up, papers}) {
    CAPTURE(options.back().second);
    CHECK(seen(scene, options) == within(expected, tolerance));
  }
}

}  // namespace

TEST_CASE("a scene without surfaces, or with none that has an area, shows its sky") {
  check(under_sky(), 1, 1e-5);
  Scene scene = under_sky();
  test::add_triangles(scene, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, test::add_material(scene, test::lambert(0.5f)));
  check(scene, 1, 1e-5);
}

TEST_CASE("a flat scene and one triangle, whose bounds have no volume, reflect the sky") {
  Scene flat = under_sky();
  test::add_horizontal(flat, 0, 0, 0, 3, 3, true, test::add_material(flat, test::lambert(0.5f)));
  check(flat, 0.5, 0.01);
  Scene triangle = under_sky();
  test::add_triangles(triangle, {{-2, 0, 1}, {2, 0, 1}, {0, 0, -2}}, test::add_material(triangle, test::lambert(0.5f)));
  check(triangle, 0.5, 0.01);
}

TEST_CASE("sheets in one place reflect the sky as one of them does") {
  Scene scene = under_sky();
  SceneMaterial grey = test::lambert(0.5f);
  for (const bool both : {false, true}) {
    grey.double_sided = both;
    test::add_horizontal(scene, 0, 0, 0, 3, 3, true, test::add_material(scene, grey));
  }
  check(scene, 0.5, 0.01);
}

TEST_CASE("a room of sheets is as bright drawn twice or three times as drawn once") {
  SceneMaterial grey = test::lambert(0.6f);
  grey.double_sided = true;
  const auto room = [&](int copies) {
    Scene scene;
    const int material = test::add_material(scene, grey), lamp = test::add_material(scene, test::emitter(5));
    for (int copy = 0; copy < copies; ++copy)
      add_instance(scene, add_mesh(scene, MeshBuilder("walls").box({-1, 0, -1}, {1, 2, 1}).take()), material);
    test::add_horizontal(scene, 0, 1.9f, 0, 0.6f, 0.6f, false, lamp);
    scene.cameras.push_back(look_at_camera("inside", {0, 1.2f, 0.8f}, {0, 0.2f, 0}, 60.f));
    return scene;
  };
  // Each copy has texels of its own.
  const auto brightness = [&](int copies) {
    return seen(room(copies), {{"dir_n", "4"},
                               {"cells", "24"},
                               {"texels", std::to_string(1024 * copies)},
                               {"camera_samples", "1"},
                               {"eye_direct", "atlas"}});
  };
  const double once = brightness(1);
  for (const int copies : {2, 3}) {
    CAPTURE(copies);
    CHECK(brightness(copies) == test::relative(once, 0.01));
  }
}

TEST_CASE("a room of sheets is as bright with others in their place, turned inside out or cut into other triangles") {
  SceneMaterial grey = test::lambert(0.6f);
  grey.double_sided = true;
  const auto room = [&](int cuts, bool inwards) {
    Scene scene;
    const int material = test::add_material(scene, grey), lamp = test::add_material(scene, test::emitter(5));
    const glm::vec3 low(-1, 0, -1), high(1, 2, 1);
    add_instance(scene, add_mesh(scene, MeshBuilder("walls").box(low, high).take()), material);
    MeshBuilder others("others");
    for (int face = 0; face < 6; ++face)
      for (int part = 0; part < cuts * cuts; ++part) {
        glm::vec3 from = low, to = high;
        for (const auto& [axis, index] :
             {std::pair{(face / 2 + 1) % 3, part % cuts}, {(face / 2 + 2) % 3, part / cuts}}) {
          const auto at = [&](int i) { return glm::mix(low[axis], high[axis], float(i) / float(cuts)); };
          from[axis] = at(index);
          to[axis] = at(index + 1);
        }
        others.box_face(from, to, face / 2, face % 2, inwards);
      }
    if (cuts > 0) add_instance(scene, add_mesh(scene, std::move(others).take()), material);
    test::add_horizontal(scene, 0, 1.9f, 0, 0.6f, 0.6f, false, lamp);
    scene.cameras.push_back(look_at_camera("inside", {0, 1.2f, 0.8f}, {0, 0.2f, 0}, 60.f));
    return scene;
  };
  const auto brightness = [&](const Scene& scene, const char* kept) {
    return seen(scene, {{"dir_n", "5"},
                        {"cells", "64"},
                        {"texels", "4096"},
                        {"camera_samples", "1"},
                        {"eye_direct", "atlas"},
                        {"cache_visibility", kept}});
  };
  const auto by_bundles = [&](const Scene& scene) {
    const auto run = test::session(
        scene, -1, {{"texels", "4096"}, {"directions", "512"}, {"stop_error", "0"}, {"camera_samples", "4"}},
        "bundle_exchange");
    run->finish_light();
    run->run({.samples = 64});
    return test::mean(test::indirect(*run));
  };
  const double once = brightness(room(0, false), "0"), bundles = by_bundles(room(0, false));
  for (const auto& [cuts, inwards] : {std::pair{1, true}, {7, false}, {7, true}}) {
    CAPTURE(cuts);
    CAPTURE(inwards);
    const double both = brightness(room(cuts, inwards), "0");
    CHECK(both == test::relative(once, 0.015));  // 18 and 26 % were missing
    CHECK(brightness(room(cuts, inwards), "64") == both);
    const double both_bundles = by_bundles(room(cuts, inwards));
    MESSAGE("indirect light by bundles: ", both_bundles / bundles);
    CHECK(both_bundles == test::relative(bundles, 0.03));  // 31 and 44 % were missing
  }
}

TEST_CASE("scenes of mirrors alone show the sky in them") {
  Scene scene = under_sky();
  const int material = test::add_material(scene, test::mirror());
  test::add_horizontal(scene, 0, 0, 0, 3, 3, true, material);
  test::add_polygon(scene, {{-1, 0, -1}, {1, 0, -1}, {1, 1, -1}, {-1, 1, -1}}, material);
  check(scene, 1, 0.01);
}

TEST_CASE("a scene that is cut out whole shows the sky, one that is half there the mean") {
  for (const bool cut : {true, false}) {
    CAPTURE(cut);
    Scene scene = under_sky();
    SceneMaterial grey = test::lambert(0.5f);
    grey.alpha_mode = cut ? AlphaMode::mask : AlphaMode::blend;
    grey.base_color.a = cut ? 0.f : 0.5f;
    grey.double_sided = true;
    test::add_horizontal(scene, 0, 0, 0, 3, 3, true, test::add_material(scene, grey));
    check(scene, cut ? 1 : 0.75, cut ? 1e-5 : 0.02);
  }
}

TEST_CASE("a box of half-transparent walls around a lamp holds light as path_tracing says") {
  SceneMaterial veil = test::lambert(0.7f);
  veil.alpha_mode = AlphaMode::blend;
  veil.base_color.a = 0.5f;
  veil.double_sided = true;
  Scene scene;
  const int material = test::add_material(scene, veil), lamp = test::add_material(scene, test::emitter(5));
  add_instance(scene, add_mesh(scene, MeshBuilder("walls").box({-1, 0, -1}, {1, 2, 1}).take()), material);
  test::add_horizontal(scene, 0, 1.7f, 0, 0.5f, 0.5f, false, lamp);
  scene.cameras.push_back(look_at_camera("inside", {0, 1.2f, 0.8f}, {0, 0.2f, 0}, 60.f));
  const auto paths = test::session(scene, -1, {{"samples_per_iteration", "64"}}, "path_tracing");
  paths->run({.samples = 512});
  const double expected = test::mean(paths->resolve().image());
  const Options options = {{"dir_n", "6"}, {"cells", "24"}, {"texels", "2048"}, {"camera_samples", "1"}};
  CHECK(seen(scene, options) == test::relative(expected, 0.03));
}
