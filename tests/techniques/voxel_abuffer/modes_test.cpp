// SPDX-License-Identifier: Apache-2.0
// The modes of voxel_abuffer, over its structure and over a hierarchy: closed forms, bits and composition.
#include <doctest/doctest.h>

#include <cmath>

#include "mode_scenes.h"
#include "technique_picture.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;
using namespace std::string_literals;

namespace {

double mean(const std::vector<float>& values) {
  double sum = 0;
  for (const float value : values) sum += static_cast<double>(value);
  return sum / static_cast<double>(values.size());
}
double layer_mean(const Scene& scene, const Picture& picture, const char* layer, const Parameters& parameters) {
  return mean(render(scene, picture, parameters).find(layer)->pixels);
}

/// The structures that tests of modes run over: a hierarchy, and A-buffers by their search.
const std::vector<std::string> kStructures = {"bvh", "exact", "auto"};
Parameters with_structure(const std::string& structure, Parameters more) {
  more.emplace_back("structure", structure == "bvh" ? "bvh" : "abuffer");
  if (structure != "bvh") more.emplace_back("intersect", structure);
  return more;
}

Parameters occlusion(const char* radius) { return {{"mode", "ao"}, {"ao_radius", radius}, {"lambda", "64"}}; }

/// A floor below a sphere of radius 1 about (0, 2, 0), seen at (x, 0, 0).
Scene sphere_above_floor(float x) {
  Scene scene;
  const int white = add_material(scene, lambert(0.5f));
  add_horizontal(scene, 0, 0, 0, 5, 5, true, white);
  add_triangles(scene, sphere_triangles({0, 2, 0}, 1, 6, false), white);
  scene.cameras.push_back(look_orthographic({x + 3, 1, 0}, {x, 0, 0}, 2e-3f));
  return scene;
}

/// Closed slabs of alpha 1/4, one below the other, over an emitter of radiance 1; nothing else lights them.
Scene slabs(int count) {
  Scene scene;
  SceneMaterial veil = lambert(0.5f);
  veil.base_color.w = 0.25f;
  veil.alpha_mode = AlphaMode::blend;
  const int material = add_material(scene, veil);
  for (int i = 0; i < count; ++i) {
    const float y = 0.2f * static_cast<float>(i);
    test::add_box(scene, {-1, y, -1}, {1, y + 0.1f, 1}, false, material);
  }
  add_horizontal(scene, 0, -1, 0, 3, 3, true, add_material(scene, emitter(1)));
  scene.cameras.push_back(look_orthographic({0, 3, 0}, {0, 0, 0}, 0.5f));
  return scene;
}

}  // namespace

TEST_CASE("modes: ambient occlusion below a sphere is (R / d)^2 cos") {
  for (const std::string& structure : kStructures) {
    CAPTURE(structure);
    for (const float x : {0.f, 2.f}) {
      const double distance = std::hypot(2.0, static_cast<double>(x));
      const double open = layer_mean(sphere_above_floor(x), {.size = 32, .iterations = 32}, "ambient_occlusion",
                                     with_structure(structure, occlusion("0")));
      CHECK(1 - open == test::relative(2 / (distance * distance * distance), 5e-3));
    }
    // Nearer than the sphere there is nothing; where it is reached, a larger radius changes nothing.
    const auto within = [&](const char* radius) {
      return layer_mean(sphere_above_floor(0), {.iterations = 4}, "ambient_occlusion",
                        with_structure(structure, occlusion(radius)));
    };
    CHECK(within("0.99") == 1);
    CHECK(within("1.2") < 0.99);
    CHECK(within("3") == within("0"));
  }
}

TEST_CASE("modes: ambient occlusion between unit squares is their form factor") {
  for (const std::string& structure : {"bvh"s, "exact"s}) {  // nothing is closed
    CAPTURE(structure);
    const int white = 0;
    Scene facing, upright;
    for (Scene* scene : {&facing, &upright}) {
      add_material(*scene, lambert(0.5f));
      add_horizontal(*scene, 0, 0, 0, 1, 1, true, white);
      scene->cameras.push_back(look_orthographic({0, 0.5f, 0}, {0, 0, 0}, 0.5f));
    }
    add_horizontal(facing, 0, 1, 0, 1, 1, false, white);
    add_polygon(upright, {{0.5f, 0, -0.5f}, {0.5f, 0, 0.5f}, {0.5f, 1, 0.5f}, {0.5f, 1, -0.5f}}, white);
    const Picture picture{.size = 64, .iterations = 8};
    const auto blocked = [&](const Scene& scene) {
      return 1 - layer_mean(scene, picture, "ambient_occlusion", with_structure(structure, occlusion("0")));
    };
    CHECK(blocked(facing) == test::relative(.199825, 5e-3));
    CHECK(blocked(upright) == test::relative(.200044, 5e-3));
  }
}

TEST_CASE("modes: Whitted's ray tracing through a slab of glass, by the number of events") {
  Scene scene;
  test::add_box(scene, {-2, -.1f, -2}, {2, 0, 2}, false, add_material(scene, clear_glass()));
  add_horizontal(scene, 0, -1, 0, 6, 6, true, add_material(scene, emitter(1)));
  scene.cameras.push_back(look_orthographic({0, 1, 0}, {0, 0, 0}, 1e-2f));
  const double r = 0.04, through = (1 - r) * (1 - r);
  for (const std::string& structure : kStructures) {
    CAPTURE(structure);
    const auto seen = [&](const char* depth) {
      return layer_mean(scene, {}, "emission", with_structure(structure, {{"mode", "whitted"}, {"depth", depth}}));
    };
    CHECK(seen("1") == 0);
    CHECK(seen("3") == test::relative(through, 1e-5));
    CHECK(seen("4") == test::relative(through * (1 + r * r), 1e-5));
    CHECK(seen("16") == test::relative(.923077, 1e-5));
  }
}

TEST_CASE("modes: light is totally reflected inside a glass cube") {
  // In through the top at 45 degrees, reflected at the wall to the right (62 degrees inside, beyond 42), out through
  // the bottom: to the lamp at the left below. Without total reflection all of it would leave to the right.
  Scene scene;
  const int glass = add_material(scene, clear_glass()), lamp = add_material(scene, emitter(1));
  test::add_box(scene, {-1, -1, -1}, {1, 1, 1}, false, glass);
  add_horizontal(scene, -1, -2, 0, 3.5f, 4, true, lamp);
  scene.cameras.push_back(look_orthographic({-0.2f, 2, 0}, {0.8f, 1, 0}, 1e-2f));
  // Schlick's approximation, as glTF has it, at the angle outside: the same into and out of the glass.
  const double through = 1 - (0.04 + 0.96 * std::pow(1 - std::sqrt(0.5), 5));
  for (const std::string& structure : kStructures) {
    CAPTURE(structure);
    const auto seen = [&](const char* depth) {
      return layer_mean(scene, {}, "emission",
                        with_structure(structure, {{"mode", "whitted"}, {"depth", depth}, {"abuffer_size", "256"}}));
    };
    CHECK(seen("2") == 0);
    CHECK(seen("3") == test::relative(through * through, 1e-5));
  }
}

TEST_CASE("modes: ray casting through eight closed slabs of alpha 1/4") {
  for (const std::string& structure : kStructures) {
    CAPTURE(structure);
    const Film film = render(slabs(8), {}, with_structure(structure, {{"mode", "cast"}}));
    // Sixteen walls and the emitter are met.
    for (const float crossings : film.find("crossings")->pixels) CHECK(crossings == 17);
    for (const float emission : film.find("emission")->pixels)
      CHECK(static_cast<double>(emission) == test::relative(std::pow(0.75, 16), 1e-5));
    // An opaque wall ends the ray.
    Scene opaque = slabs(8);
    opaque.materials[0].alpha_mode = AlphaMode::opaque;
    const Film walls = render(opaque, {}, with_structure(structure, {{"mode", "cast"}}));
    for (const float crossings : walls.find("crossings")->pixels) CHECK(crossings == 1);
  }
}

TEST_CASE("modes: over exact search every mode has the bits of the hierarchy, and path those of path_tracing") {
  const Scene scene = showcase();
  struct Case {
    const char* mode;
    int max_bounces;
  };
  for (const Case& c : {Case{"cast", 2}, {"whitted", 2}, {"ao", 2}, {"path", 0}, {"path", 2}, {"path", -1}}) {
    CAPTURE(std::string(c.mode));
    CAPTURE(c.max_bounces);
    const Picture picture{.size = 24, .iterations = 2, .max_bounces = c.max_bounces};
    const Film exact = render(scene, picture, {{"mode", c.mode}, {"intersect", "exact"}, {"abuffer_size", "256"}});
    const Film hierarchy = render(scene, picture, {{"mode", c.mode}, {"structure", "bvh"}});
    REQUIRE(exact.layers().size() == hierarchy.layers().size());
    for (const FilmLayer& layer : exact.layers()) CHECK(layer.pixels == hierarchy.find(layer.name)->pixels);
    if (c.mode != std::string("path")) continue;
    Picture other = picture;
    other.technique = "path_tracing";
    const Film reference = render(scene, other, {});
    for (const FilmLayer& layer : reference.layers()) CHECK(layer.pixels == exact.find(layer.name)->pixels);
    CHECK(mean(reference.find("direct")->pixels) > 0);
    if (c.max_bounces != 0) CHECK(mean(reference.find("indirect")->pixels) > 0);
  }
}

TEST_CASE("modes: progressive and general composition, and one and two threads, have the same bits") {
  const Scene scene = showcase();
  for (const char* mode : {"cast", "whitted", "ao", "path"}) {
    CAPTURE(mode);
    const auto layers = [&](uint64_t iterations, int threads, Parameters more) {
      more.insert(more.end(), {{"mode", mode}, {"lambda", "2"}, {"passes", "3"}, {"abuffer_size", "256"}});
      const Film film =
          render(scene, {.iterations = iterations, .max_bounces = 1, .device = {.threads = threads}}, more);
      std::vector<float> all;
      for (const FilmLayer& layer : film.layers()) all.insert(all.end(), layer.pixels.begin(), layer.pixels.end());
      return all;
    };
    const Parameters general = {{"progressive", "off"}, {"rebuild", "frame"}};
    const std::vector<float> progressive = layers(3, 0, {});
    CHECK(layers(3, 0, general) == progressive);
    CHECK(layers(3, 1, {}) == progressive);
    CHECK(layers(3, 2, general) == progressive);
    CHECK(layers(7, 0, {}) == progressive);            // a frame is complete after its passes
    CHECK(layers(5, 0, general) == layers(2, 0, {}));  // or begins again
    CHECK(layers(2, 0, {}) != progressive);
  }
}

TEST_CASE("modes: constant light is the albedo's share, and no other layer changes") {
  Scene scene;
  add_horizontal(scene, 0, 0, 0, 4, 4, true, add_material(scene, lambert(0.5f)));
  scene.cameras.push_back(look_orthographic({0, 1, 0}, {0, 0, 0}, 0.5f));
  const Film film = render(scene, {}, {{"mode", "whitted"}, {"ambient", "3"}});
  for (const float value : film.find("ambient")->pixels) CHECK(static_cast<double>(value) == test::relative(1.5, 1e-6));
  CHECK(mean(film.find("direct")->pixels) == 0);
  CHECK(!render(scene, {}, {{"mode", "whitted"}}).find("ambient"));
}

TEST_CASE("modes: what does not go together is refused, naming the parameter") {
  const Scene scene = showcase();
  CHECK_THROWS_WITH_AS(render(scene, {}, {{"progressive", "off"}}),
                       "voxel_abuffer: progressive=off with passes=0: a frame would never end; set passes to 1 or more",
                       Error);
  CHECK_THROWS_WITH_AS(render(scene, {}, {{"grid_size", "7"}}),
                       "voxel_abuffer: grid_size 7 is neither 0 nor 16 to 2048", Error);
  CHECK_THROWS_WITH_AS(render(scene, {}, {{"ao_radius", "-0.5"}}),
                       "voxel_abuffer: ao_radius -0.5 is negative and not -1", Error);
}
