// SPDX-License-Identifier: Apache-2.0
// Scenes in which every mode of voxel_abuffer has something to do.
#pragma once
#include "made_scene.h"

namespace lucarium::test {

/// Things behind veils, glass and mirrors, under a lamp, a point light and a sky.
inline Scene showcase() {
  Scene scene;
  add_horizontal(scene, 0, 0, 0, 6, 6, true, add_material(scene, lambert(0.6f)));
  SceneMaterial veil = lambert(0.8f);
  veil.base_color.w = 0.4f;
  veil.alpha_mode = AlphaMode::blend;
  veil.double_sided = true;
  add_horizontal(scene, -0.7f, 0.8f, 0, 1, 1, true, add_material(scene, veil));
  SceneMaterial mirror;
  mirror.roughness = 0;
  test::add_box(scene, {0.2f, 0, -1}, {1.2f, 0.7f, -0.4f}, false, add_material(scene, mirror));
  add_triangles(scene, sphere_triangles({0.2f, 0.35f, 0.5f}, 0.35f, 4, false), add_material(scene, clear_glass()));
  SceneMaterial lamp = emitter(4);
  add_horizontal(scene, 0, 2.5f, 0, 0.8f, 0.8f, false, add_material(scene, lamp));
  add_light(scene, LightType::point, 1, {1.5f, 1.2f, 1.5f}, {0, 0, 0});
  set_environment(scene, 0.3f);
  scene.cameras.push_back(look_perspective({0.5f, 1.6f, 3.2f}, {0.1f, 0.3f, 0}, 0.7f));
  return scene;
}

/// The like of it, of closed bodies that do not touch.
inline Scene closed_showcase() {
  Scene scene;
  test::add_box(scene, {-3, -0.3f, -3}, {3, 0, 3}, false, add_material(scene, lambert(0.6f)));
  SceneMaterial veil = lambert(0.8f);
  veil.base_color.w = 0.4f;
  veil.alpha_mode = AlphaMode::blend;
  test::add_box(scene, {-1.2f, 0.7f, -0.5f}, {-0.2f, 0.8f, 0.5f}, false, add_material(scene, veil));
  SceneMaterial mirror;
  mirror.roughness = 0;
  test::add_box(scene, {0.2f, 0.05f, -1}, {1.2f, 0.75f, -0.4f}, false, add_material(scene, mirror));
  add_triangles(scene, sphere_triangles({0.2f, 0.4f, 0.5f}, 0.35f, 4, false), add_material(scene, clear_glass()));
  add_triangles(scene, sphere_triangles({-0.8f, 0.35f, 0.6f}, 0.3f, 4, false), add_material(scene, lambert(0.7f)));
  test::add_box(scene, {-0.4f, 2.5f, -0.4f}, {0.4f, 2.6f, 0.4f}, false, add_material(scene, emitter(4)));
  add_light(scene, LightType::point, 1, {1.5f, 1.2f, 1.5f}, {0, 0, 0});
  set_environment(scene, 0.3f);
  scene.cameras.push_back(look_perspective({0.5f, 1.6f, 3.2f}, {0.1f, 0.3f, 0}, 0.7f));
  return scene;
}

}  // namespace lucarium::test
