// SPDX-License-Identifier: Apache-2.0
// Ideal refraction: a plane-parallel slab, whose inner reflections sum to T = (1 - R) / (1 + R) with Schlick's R.
#include "test_render.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

Effort glass_effort() { return full_run() ? Effort{64, 16, 128} : Effort{32, 16, 32}; }

/// A slab between y = -0.1 and 0 above a wide emitter of radiance 1 that faces it.
Scene slab_scene(const SceneMaterial& material, float emitter_radiance = 1) {
  Scene scene;
  add_box(scene, {-20, -.1f, -20}, {20, 0, 20}, false, add_material(scene, material));
  add_horizontal(scene, 0, -1, 0, 60, 60, true, add_material(scene, emitter(emitter_radiance)));
  return scene;
}

SceneCamera tilted_glass(double cosine) {
  const double sine = std::sqrt(1 - cosine * cosine);
  return look_orthographic({static_cast<float>(2 * sine), static_cast<float>(2 * cosine), 0}, {0, 0, 0}, 1e-3f);
}

}  // namespace

TEST_CASE("glass: transmittance of a slab of index 1.5") {
  ClosedForms table;
  table.add("0 degrees", estimate(slab_scene(clear_glass()), tilted_glass(1), {}, glass_effort()), .923077);
  table.add("60 degrees", estimate(slab_scene(clear_glass()), tilted_glass(0.5), {}, glass_effort()), .869159);
  table.check(2e-3);
}

TEST_CASE("glass: Beer's law along the refracted way") {
  SceneMaterial tinted = clear_glass();
  tinted.attenuation_color = glm::vec3(0.25f);
  tinted.attenuation_distance = 0.2f;
  const double sigma = std::log(4.0) / 0.2;
  ClosedForms table;
  for (const double cosine : {1.0, 0.5}) {
    const double sine_inside = std::sqrt(1 - cosine * cosine) / 1.5;
    const double a = std::exp(-sigma * 0.1 / std::sqrt(1 - sine_inside * sine_inside));
    const double r = 0.04 + 0.96 * std::pow(1 - cosine, 5);
    table.add("cos " + std::to_string(cosine), estimate(slab_scene(tinted), tilted_glass(cosine), {}, glass_effort()),
              (1 - r) * (1 - r) * a / (1 - r * r * a * a));
  }
  table.check(2e-3);
}

TEST_CASE("glass: a thin wall does not bend, and reflects R") {
  // No volume: one interface, transmittance 1 - R.
  SceneMaterial wall = clear_glass();
  wall.thickness = 0;
  Scene scene;
  add_horizontal(scene, 0, 0, 0, 40, 40, true, add_material(scene, wall));
  add_horizontal(scene, 0, -1, 0, 60, 60, true, add_material(scene, emitter(1)));
  ClosedForms table;
  table.add("60 degrees", estimate(scene, tilted_glass(0.5), {}, glass_effort()), 1 - (0.04 + 0.96 * std::pow(0.5, 5)));
  table.check(2e-3);
}

TEST_CASE("glass: a faceted sphere in a furnace loses nothing") {
  // Total reflection keeps some light within the facets for hundreds of events: no path may end for their number alone.
  Scene scene;
  add_triangles(scene, sphere_triangles({0, 0, 0}, 1, 5, false), add_material(scene, clear_glass()));
  set_environment(scene, 1);
  PathIntegratorOptions without;
  without.roulette = false;
  ClosedForms table;
  table.add("roulette", estimate(scene, look_orthographic({0, 0, 3}, {0, 0, 0}, 1.1f), {}, glass_effort()), 1);
  table.add("no roulette", estimate(scene, look_orthographic({0, 0, 3}, {0, 0, 0}, 1.1f), without, glass_effort()), 1);
  table.check(full_run() ? 5e-4 : 2e-3);
}

TEST_CASE("glass: delta events on the eye's side can be left out") {
  PathIntegratorOptions options;
  options.path_set.eye_deltas = 0;
  CHECK(estimate(slab_scene(clear_glass()), tilted_glass(1), options, {16, 2, 4}).mean == 0);
}
