// SPDX-License-Identifier: Apache-2.0
// Lamps over mirrors and behind glass: light of ideal surfaces that splats and hits find, each alone.
#include "bidirectional_rig.h"
#include "made_scene.h"
#include "polygon_irradiance.h"

using namespace lucarium;
using namespace lucarium::test;

TEST_CASE("mirrored lamp: a wall gets what the lamp's mirror image sends, by splats alone and by hits alone") {
  // The lamp shines down on a mirror, beside a wall at x = 1 that sees the lamp only from the front, directly and
  // mirrored. Light of one bounce is the mirrored one alone.
  const float albedo = 0.5f, half = 0.25f;
  Scene scene;
  SceneMaterial mirror;
  mirror.roughness = 0;
  add_horizontal(scene, 0, 0, 0, 3, 3, true, add_material(scene, mirror));
  add_horizontal(scene, 0, 1, 0, 2 * half, 2 * half, false, add_material(scene, emitter(1)));
  add_polygon(scene, {{1, 0, -1.5f}, {1, 0, 1.5f}, {1, 2, 1.5f}, {1, 2, -1.5f}}, add_material(scene, lambert(albedo)));
  const glm::dvec3 middle(1, 0.6, 0);
  scene.cameras = {look_orthographic({0.8f, 0.6f, 0}, {1, 0.6f, 0}, half)};

  double irradiance = 0;
  const int grid = 32;
  const double h = double{half};
  const std::vector<glm::dvec3> image = {{-h, -1, -h}, {h, -1, -h}, {h, -1, h}, {-h, -1, h}};
  for (int i = 0; i < grid; ++i)
    for (int j = 0; j < grid; ++j) {
      const glm::dvec3 offset(0, (2 * (i + 0.5) / grid - 1) * h, (2 * (j + 0.5) / grid - 1) * h);
      irradiance += polygon_irradiance(middle + offset, {-1, 0, 0}, image) / (grid * grid);
    }

  Picture picture;
  picture.width = picture.height = 16;
  picture.max_bounces = 1;
  picture.iterations = full_run() ? 4096 : 32;
  const double expected = irradiance * double{albedo} / M_PI;
  ClosedForms table;
  table.add("splat", indirect(scene, picture, {{"strategy", "splat"}, {"light_paths", "8192"}}), expected);
  table.add("all", indirect(scene, picture, {{"light_paths", "8192"}}), expected);
  picture.iterations *= 8;
  table.add("hit", indirect(scene, picture, {{"strategy", "hit"}}), expected);
  table.check(0.02);
}

TEST_CASE("glass slab: a floor behind it gets (1 - R) / (1 + R) of each direction's light") {
  // Inner reflections sum to T = (1 - R) / (1 + R) with Schlick's R. Below an even ceiling the floor gets
  // E = 2 pi (integral of T cos), and what it sends back to the slab returns with 2 R / (1 + R).
  const float albedo = 0.3f;
  Scene scene;
  SceneMaterial glass = clear_glass();
  add_horizontal(scene, 0, 1, 0, 60, 60, false, add_material(scene, emitter(1)));
  add_box(scene, {-30, 0.5f, -30}, {30, 0.6f, 30}, false, add_material(scene, glass));
  add_horizontal(scene, 0, 0, 0, 60, 60, true, add_material(scene, lambert(albedo)));
  scene.cameras = {look_orthographic({0, 0.3f, 0}, {0, 0, 0}, 2)};
  double through = 0, back = 0;
  const int steps = 20000;
  for (int i = 0; i < steps; ++i) {
    const double cosine = (i + 0.5) / steps, r = 0.04 + 0.96 * std::pow(1 - cosine, 5);
    through += 2 * cosine * (1 - r) / (1 + r) / steps;
    back += 2 * cosine * 2 * r / (1 + r) / steps;
  }
  const double expected = through * double{albedo} / (1 - back * double{albedo});
  Picture picture;
  picture.width = picture.height = 16;
  picture.max_bounces = -1;
  picture.iterations = full_run() ? 2048 : 16;
  ClosedForms table;
  // The ceiling ends: what lies beyond 28 m is 1e-4 of it.
  table.add("all", indirect(scene, picture, {}), expected, 3e-4 * expected);
  picture.iterations *= 4;
  table.add("hit", indirect(scene, picture, {{"strategy", "hit"}}), expected, 3e-4 * expected);
  // Light paths have 16 vertices at most: more inner reflections are left out, and those of light that the floor has
  // sent back (5e-4 of all).
  table.add("splat",
            indirect(scene, picture, {{"strategy", "splat"}, {"light_vertices", "16"}, {"light_paths", "4096"}}),
            expected, 1e-3 * expected);
  table.check(0.02);
}
