// SPDX-License-Identifier: Apache-2.0
// The small built-in scenes: Cornell boxes, furnace. Declared in builder.h.
#include <array>
#include <cmath>

#include "lucarium/scene/builtin/builder.h"

namespace lucarium {

namespace {

// The Cornell box (Goral et al. 1984; data of the Cornell Program of Computer Graphics, millimetres), its walls made
// rectangular. Turned by half a turn about Y and centred, so that the camera looks along -Z; red is on the left.
constexpr float box_width = 0.5528f, box_height = 0.5488f, box_depth = 0.5592f;

glm::vec2 cornell_xz(float x_mm, float z_mm) { return {0.5f * box_width - 0.001f * x_mm, -0.001f * z_mm}; }

/// Ceiling with the lamp's opening: a ring of four trapezoids that share their edges.
Mesh cornell_ceiling(const glm::vec2& hole_min, const glm::vec2& hole_max) {
  const float x = 0.5f * box_width, y = box_height;
  const glm::vec3 outer[4] = {{-x, y, 0}, {-x, y, -box_depth}, {x, y, -box_depth}, {x, y, 0}};
  const glm::vec3 inner[4] = {{hole_min.x, y, hole_max.y},
                              {hole_min.x, y, hole_min.y},
                              {hole_max.x, y, hole_min.y},
                              {hole_max.x, y, hole_max.y}};
  MeshBuilder builder("ceiling");
  for (int i = 0; i < 4; ++i) {
    const int next = (i + 1) % 4;
    builder.quad(outer[i], outer[next], inner[next], inner[i]);
  }
  return builder.take();
}

Mesh one_face(const std::string& name, const glm::vec3& min, const glm::vec3& max, int axis, int side) {
  return MeshBuilder(name).box_face(min, max, axis, side, true).take();
}

}  // namespace

Scene make_cornell(const std::string& variant) {
  Scene scene;
  const int white = add_lambert(scene, "white", {0.725f, 0.71f, 0.68f});
  const int red = add_lambert(scene, "red", {0.63f, 0.065f, 0.05f});
  const int green = add_lambert(scene, "green", {0.14f, 0.45f, 0.091f});
  const int lamp = add_emitter(scene, "lamp", {17.f, 14.f, 9.5f});
  int tall = white;
  if (variant == "mirror") tall = add_metal(scene, "mirror", {0.8f, 0.8f, 0.8f}, 0.f);
  if (variant == "glossy") tall = add_metal(scene, "glossy", {0.8f, 0.8f, 0.8f}, 0.3f);

  // Walls that face inwards; the side of the camera is open.
  const glm::vec3 low(-0.5f * box_width, 0, -box_depth), high(0.5f * box_width, box_height, 0);
  add_instance(scene, add_mesh(scene, one_face("floor", low, high, 1, 0)), white);
  add_instance(scene, add_mesh(scene, one_face("back wall", low, high, 2, 0)), white);
  add_instance(scene, add_mesh(scene, one_face("left wall", low, high, 0, 0)), red);
  add_instance(scene, add_mesh(scene, one_face("right wall", low, high, 0, 1)), green);
  const glm::vec2 lamp_min = cornell_xz(343, 332), lamp_max = cornell_xz(213, 227);
  add_instance(scene, add_mesh(scene, cornell_ceiling(lamp_min, lamp_max)), white);
  add_instance(
      scene, add_mesh(scene, one_face("lamp", {lamp_min.x, 0, lamp_min.y}, {lamp_max.x, box_height, lamp_max.y}, 1, 1)),
      lamp);

  const std::vector<glm::vec2> short_block = {cornell_xz(130, 65), cornell_xz(82, 225), cornell_xz(240, 272),
                                              cornell_xz(290, 114)};
  const std::vector<glm::vec2> tall_block = {cornell_xz(423, 247), cornell_xz(265, 296), cornell_xz(314, 456),
                                             cornell_xz(472, 406)};
  add_instance(scene, add_mesh(scene, MeshBuilder("short block").prism(short_block, 0, 0.165f).take()), white);
  add_instance(scene, add_mesh(scene, MeshBuilder("tall block").prism(tall_block, 0, 0.33f).take()), tall);

  scene.cameras.push_back(look_at_camera("front", {-0.0016f, 0.273f, 0.8f}, {-0.0016f, 0.273f, 0.f}, 39.3f));
  scene.camera_paths.push_back(walk({{0, {-0.0016f, 0.273f, 0.8f}, {-0.0016f, 0.273f, 0.f}, 39.3f},
                                     {1, {-0.12f, 0.3f, 0.4f}, {0.03f, 0.22f, -0.25f}, 50.f},
                                     {2, {-0.15f, 0.35f, 0.05f}, {0.08f, 0.15f, -0.3f}, 60.f},
                                     {3, {0.16f, 0.4f, 0.1f}, {-0.1f, 0.15f, -0.35f}, 60.f},
                                     {4, {0.1f, 0.25f, 0.5f}, {-0.05f, 0.2f, -0.2f}, 45.f}}));
  return scene;
}

Scene make_furnace() {
  Scene scene;
  // Flat facets: then radiance is exactly albedo x environment everywhere (a convex Lambertian body).
  const int white = add_lambert(scene, "white", glm::vec3(0.8f));
  MeshBuilder builder("sphere");
  for (const auto& [a, b, c] : icosphere(3)) builder.triangle(a, b, c);
  add_instance(scene, add_mesh(scene, builder.take()), white);
  scene.environment = Environment{};
  scene.environment->name = "white";
  scene.cameras.push_back(look_at_camera("front", {0, 0, 3.5f}, {0, 0, 0}, 40.f));
  return scene;
}

}  // namespace lucarium
