// SPDX-License-Identifier: Apache-2.0
// builtin:mirror-hall: a figure among columns before a wall that is half mirror, half plaster, in as many triangles as
// the scene "Atenea" of Mortensen et al. (2007). Declared in builder.h.
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "lucarium/scene/builtin/builder.h"

namespace lucarium {

namespace {

constexpr glm::vec3 mirrors_min{-3.f, 0.f, -4.f}, mirrors_max{3.f, 3.6f, 4.f};

/// Outline of a draped figure of 1.7 m: `rows` + 1 points (radius, height), closed at both ends.
std::vector<glm::vec2> figure_outline(int rows) {
  std::vector<glm::vec2> outline;
  for (int i = 0; i <= rows; ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(rows);
    const float body = 0.34f - 0.14f * t + 0.07f * std::sin(9.f * t);
    const float head = 0.13f * std::sqrt(std::max(0.f, 1 - std::pow((t - 0.9f) / 0.1f, 2.f)));
    const float neck = glm::smoothstep(0.76f, 0.82f, t);
    const float radius = i == 0 || i == rows ? 0.f : glm::mix(body, std::max(head, 0.06f * (1 - t) / 0.1f), neck);
    outline.emplace_back(radius, 1.7f * t);
  }
  return outline;
}

/// Smooth folds all around: the figure's radius changes with the angle.
Mesh figure_mesh() {
  constexpr int rows = 43, columns = 60;
  std::vector<glm::vec3> positions;
  for (const glm::vec2& p : figure_outline(rows)) {
    const float folds = 0.08f * (1 - p.y / 1.7f);
    for (int i = 0; i < columns; ++i) {
      const float angle = 2 * glm::pi<float>() * static_cast<float>(i) / columns;
      const float radius = p.x * (1 + folds * std::cos(9 * angle + 2 * p.y));
      positions.emplace_back(radius * std::cos(angle), p.y, -radius * std::sin(angle));
    }
  }
  return MeshBuilder("figure").sheet(positions, rows + 1, columns, true).take();
}

/// A column of 3 m with base and capital; open where it stands and at its top, which its abacus hides.
Mesh column_mesh() {
  std::vector<glm::vec2> shaft;
  constexpr int rows = 8;
  for (int i = 0; i <= rows; ++i) {
    const float t = static_cast<float>(i) / rows;
    shaft.emplace_back(0.2f - 0.035f * t * t, 0.15f + 2.65f * t);  // swelling towards the foot
  }
  MeshBuilder builder("column");
  builder.revolve(
      {{{0.26f, 0.f}, {0.26f, 0.15f}}, {{0.26f, 0.15f}, {0.2f, 0.15f}}, shaft, {{0.165f, 2.8f}, {0.25f, 3.f}}}, 24);
  builder.box({-0.28f, 3.f, -0.28f}, {0.28f, 3.15f, 0.28f});
  return builder.take();
}

/// Walls, floor and ceiling; the wall -x is the mirror.
void add_walls(Scene& scene) {
  const int plaster = add_lambert(scene, "plaster", {0.7f, 0.68f, 0.62f}),
            ochre = add_lambert(scene, "ochre", {0.65f, 0.42f, 0.2f}),
            blue = add_lambert(scene, "blue", {0.25f, 0.35f, 0.55f}),
            floor = add_lambert(scene, "floor", {0.45f, 0.4f, 0.36f});
  SceneMaterial half;  // no coat: half of its light is a mirror's, half is diffuse
  half.name = "half mirror";
  half.base_color = glm::vec4(0.8f, 0.8f, 0.8f, 1);
  half.metallic = 0.5f;
  half.roughness = 0;
  half.ior = 1;
  scene.materials.push_back(half);
  const int mirror = static_cast<int>(scene.materials.size()) - 1;
  const int materials[3][2] = {{mirror, plaster}, {floor, plaster}, {ochre, blue}};
  const char* names[3][2] = {{"mirror", "wall +x"}, {"floor", "ceiling"}, {"wall -z", "wall +z"}};
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      Mesh face = MeshBuilder(names[axis][side]).box_face(mirrors_min, mirrors_max, axis, side, true).take();
      add_instance(scene, add_mesh(scene, std::move(face)), materials[axis][side]);
    }
  }
}

}  // namespace

Scene make_mirror_hall() {
  Scene scene;
  add_walls(scene);
  const int marble = add_lambert(scene, "marble", {0.75f, 0.72f, 0.68f});
  const glm::vec3 place(0.2f, 0.f, -0.6f);
  add_instance(scene, add_mesh(scene, MeshBuilder("pedestal").box({-0.4f, 0, -0.4f}, {0.4f, 0.5f, 0.4f}).take()),
               marble, glm::translate(glm::mat4(1.f), place));
  add_instance(scene, add_mesh(scene, figure_mesh()), marble,
               glm::translate(glm::mat4(1.f), place + glm::vec3(0, 0.501f, 0)));
  const int column = add_mesh(scene, column_mesh());
  for (const float x : {-1.9f, 2.1f}) {
    for (const float z : {-2.8f, -1.1f, 0.6f, 2.3f})
      add_instance(scene, column, marble, glm::translate(glm::mat4(1.f), glm::vec3(x, 0, z)));
  }
  const int lamp = add_emitter(scene, "lamp", {16.f, 14.5f, 12.f});
  const float y = mirrors_max.y - 0.01f;
  for (const float z : {-2.f, 1.5f}) {
    Mesh quad = MeshBuilder("lamp")
                    .quad({-0.4f, y, z - 0.4f}, {0.8f, y, z - 0.4f}, {0.8f, y, z + 0.4f}, {-0.4f, y, z + 0.4f})
                    .take();
    add_instance(scene, add_mesh(scene, std::move(quad)), lamp);
  }
  scene.cameras.push_back(look_at_camera("front", {1.4f, 1.6f, 3.6f}, {-0.9f, 1.2f, -1.2f}, 60.f));
  scene.camera_paths.push_back(walk({{0, {1.4f, 1.6f, 3.6f}, {-0.9f, 1.2f, -1.2f}, 60.f},
                                     {2, {0.1f, 1.6f, 2.2f}, {-1.5f, 1.2f, -0.8f}, 60.f},
                                     {4, {-1.1f, 1.7f, 0.9f}, {0.1f, 1.3f, -0.7f}, 60.f},
                                     {6, {-0.9f, 1.6f, -2.2f}, {0.3f, 1.2f, -0.4f}, 60.f},
                                     {8, {1.2f, 1.5f, -2.4f}, {-1.2f, 1.3f, 0.6f}, 60.f}}));
  return scene;
}

}  // namespace lucarium
