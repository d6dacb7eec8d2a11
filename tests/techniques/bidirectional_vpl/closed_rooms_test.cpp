// SPDX-License-Identifier: Apache-2.0
// Closed rooms whose light is known: the golden room, boxes of one albedo, boxes and skies that shine alike everywhere.
#include "bidirectional_rig.h"
#include "lucarium/scene/builtin/scenes.h"
#include "made_scene.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// Mean of one layer over independent pictures.
Estimate mean_of_layer(const Scene& scene, const Picture& picture, const char* layer, const Parameters& parameters) {
  return estimate_of(layer_means(scene, "bidirectional_vpl", picture, layer, parameters, 20));
}

Picture square(uint32_t side, int max_bounces, uint64_t iterations) {
  Picture picture;
  picture.width = picture.height = side;
  picture.max_bounces = max_bounces;
  picture.iterations = iterations;
  return picture;
}

}  // namespace

TEST_CASE("room: golden floor irradiances of bounces 1 to 4") {
  // Those of tests/analytic/room_test.cpp, by an independent path tracer, each within 1e-4.
  struct Point {
    float x, z;
    double irradiance[4];
  };
  const Point points[] = {{-.5f, .3f, {.2931, .1698, .0970, .0545}},
                          {-.98f, -.97f, {.1709, .1506, .0895, .0557}},
                          {.8f, -.8f, {.1402, .0907, .0569, .0346}}};
  const std::vector<Parameters> variants = {{}, {{"preset", "bdpt"}}, {{"light_vertices", "1"}}};
  const double floor_albedo = 0.7;
  Scene scene = make_builtin_scene("room");
  ClosedForms table;
  for (const Point& point : points) {
    scene.cameras = {look_orthographic({point.x, 0.01f, point.z}, {point.x, 0, point.z}, 1e-5f)};
    for (size_t variant = 0; variant < variants.size(); ++variant) {
      double expected = 0;
      for (int bounces = 1; bounces <= 4; ++bounces) {
        expected += point.irradiance[bounces - 1];
        if (!full_run() && (bounces != 4 || (variant > 0 && &point != points))) continue;
        const Picture picture = square(16, bounces, full_run() ? 2048 : 32);
        Estimate e = mean_of_layer(scene, picture, "indirect", variants[variant]);
        e.mean *= M_PI / floor_albedo;
        e.error *= M_PI / floor_albedo;
        table.add("(" + std::to_string(point.x) + ", " + std::to_string(point.z) + ") to bounce " +
                      std::to_string(bounces) + ", variant " + std::to_string(variant),
                  e, expected, 1e-4 * bounces);
      }
    }
  }
  table.check(0.03);
}

TEST_CASE("in a closed box of one albedo each bounce brings the light's power times the albedo") {
  // Integral of E_k over all walls = albedo^k 4 pi I, wherever the light is. A camera sees one wall; with the light in
  // the middle all walls are alike.
  const float albedo = 0.6f;
  const bool middle = !full_run();
  Scene scene;
  add_box(scene, glm::vec3(-0.5f), glm::vec3(0.5f), true, add_material(scene, lambert(albedo)));
  add_light(scene, LightType::point, 1, middle ? glm::vec3(0) : glm::vec3(0.2f, 0.1f, -0.3f), {0, -1, 0});
  const std::vector<std::pair<std::string, Parameters>> variants = {
      {"vpl", {{"strategy", "vpl"}}}, {"splat", {{"strategy", "splat"}}}, {"all", {}}};
  ClosedForms table;
  for (const auto& [name, parameters] : variants) {
    for (const int bounces : full_run() ? std::vector<int>{1, 2, 3} : std::vector<int>{1, 3}) {
      std::vector<double> sums(kSeeds);
      for (const glm::vec3 axis : {glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0, 1)}) {
        for (const float side : {-0.5f, 0.5f}) {
          if (middle && (axis.x == 0 || side < 0)) continue;
          scene.cameras = {look_orthographic(glm::vec3(0), side * axis, 0.5f)};
          const Picture picture = square(16, bounces, full_run() ? 4096 : 64);
          Parameters all = parameters;
          all.push_back({"light_paths", "256"});
          const std::vector<double> means = layer_means(scene, "bidirectional_vpl", picture, "indirect", all, 20);
          for (uint32_t i = 0; i < kSeeds; ++i) sums[i] += means[i] * M_PI / double{albedo} * (middle ? 6 : 1);
        }
      }
      double expected = 0;
      for (int k = 1; k <= bounces; ++k) expected += std::pow(double{albedo}, k) * 4 * M_PI;
      table.add(name + ", to bounce " + std::to_string(bounces), estimate_of(sums), expected);
    }
  }
  table.check(0.02);
}

TEST_CASE("a box that shines alike everywhere shows the sum of its albedo's powers") {
  const float albedo = 0.5f;
  Scene scene;
  add_box(scene, glm::vec3(-0.5f), glm::vec3(0.5f), true, add_material(scene, emitter(1, albedo)));
  scene.cameras = {look_perspective({0.3f, 0.2f, 0.4f}, {-0.2f, -0.3f, -0.5f}, 1.2f)};
  ClosedForms table;
  for (const auto& [name, parameters] : std::vector<std::pair<std::string, Parameters>>{
           {"default", {}}, {"bdpt", {{"preset", "bdpt"}}}, {"bundles", {{"directions", "bundle"}}}}) {
    for (const int bounces : {1, 3}) {
      const Picture picture = square(16, bounces, full_run() ? 2048 : 16);
      double expected = 0;
      for (int k = 2; k <= bounces + 1; ++k) expected += std::pow(double{albedo}, k);
      table.add(name + ", to bounce " + std::to_string(bounces), mean_of_layer(scene, picture, "indirect", parameters),
                expected);
    }
  }
  table.check(0.02);
}

TEST_CASE("furnace: bodies under an even sky show their albedo, and lose nothing in glass") {
  ClosedForms table;
  const float rho = 0.8f;
  Scene body;
  add_triangles(body, sphere_triangles({0, 0, 0}, 1, 3, false), add_material(body, lambert(rho)));
  set_environment(body, 1);
  body.cameras = {look_orthographic({0, 0, 5}, {0, 0, 0}, 0.65f)};
  const Picture picture = square(16, -1, full_run() ? 1024 : 16);
  table.add("Lambert", mean_of_layer(body, picture, "direct", {}), rho);

  // A white floor below a glass block, unlimited bounces: everything that is sent out comes back.
  SceneMaterial glass = clear_glass();
  Scene block;
  add_horizontal(block, 0, -1, 0, 4, 4, true, add_material(block, lambert(1)));
  add_box(block, {-1, -0.6f, -1}, {1, -0.3f, 1}, false, add_material(block, glass));
  set_environment(block, 1);
  // Glass conserves energy to what Schlick's R loses on the way (tests/analytic/glass_test.cpp): nothing for ideal
  // lobes.
  block.cameras = {look_orthographic({0.7f, 1.2f, 0.4f}, {0.1f, -1, 0}, 0.4f)};
  std::vector<double> sums;
  Picture first = picture;
  first.seed = 40;
  for (const Film& film : films(block, "bidirectional_vpl", first, {}, kSeeds)) sums.push_back(mean_of(image_of(film)));
  table.add("floor below glass", estimate_of(sums), 1);
  table.check(0.01);
}
