// SPDX-License-Identifier: Apache-2.0
// builtin:blocks: a closed room full of blocks, of as many triangles as asked for, whose area does not depend on their
// number, and with as many lights of the same area: what a technique's time does with triangles or lights alone.
// Declared in builder.h.
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/quaternion.hpp>
#include <map>

#include "lucarium/base/seed.h"
#include "lucarium/scene/builtin/builder.h"

namespace lucarium {

namespace {

constexpr glm::vec3 room_min{-2.f, 0.f, -2.f}, room_max{2.f, 3.f, 2.f};
constexpr float blocks_area = 16;                       // of all blocks [m²]
constexpr int faces_of_block = 12, faces_of_room = 14;  // the lamp among them

/// A number from 0 to 1 that the block and `use` decide.
float random(int block, uint32_t use) {
  return static_cast<float>(mixed_seed(static_cast<uint32_t>(block), use)) * 0x1p-32f;
}

/// A cube of edge `edge` about `centre`, turned; its six faces outwards.
void add_cube(MeshBuilder& builder, const glm::vec3& centre, float edge, const glm::quat& turn) {
  const auto corner = [&](int x, int y, int z) {
    return centre +
           turn * (edge * (glm::vec3(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)) - 0.5f));
  };
  builder.quad(corner(0, 0, 1), corner(1, 0, 1), corner(1, 1, 1), corner(0, 1, 1));
  builder.quad(corner(1, 0, 0), corner(0, 0, 0), corner(0, 1, 0), corner(1, 1, 0));
  builder.quad(corner(1, 0, 1), corner(1, 0, 0), corner(1, 1, 0), corner(1, 1, 1));
  builder.quad(corner(0, 0, 0), corner(0, 0, 1), corner(0, 1, 1), corner(0, 1, 0));
  builder.quad(corner(0, 1, 1), corner(1, 1, 1), corner(1, 1, 0), corner(0, 1, 0));
  builder.quad(corner(0, 0, 0), corner(1, 0, 0), corner(1, 0, 1), corner(0, 0, 1));
}

/// The floor in 2 + `more` triangles: a fan about one of its corners.
Mesh floor_fan(int more) {
  const glm::vec3 hub(room_min.x, 0, room_max.z), end(room_max.x, 0, room_min.z), far(room_min.x, 0, room_min.z);
  MeshBuilder builder("floor");
  builder.triangle(hub, {room_max.x, 0, room_max.z}, end);
  const auto on_edge = [&](int i) { return glm::mix(end, far, static_cast<float>(i) / static_cast<float>(more + 1)); };
  for (int i = 0; i <= more; ++i) builder.triangle(hub, on_edge(i), on_edge(i + 1));
  return builder.take();
}

/// One square metre of lamp below the ceiling: a square, or as many equal triangles on a grid.
Mesh lamp_mesh(int lights) {
  const float y = room_max.y - 0.01f;
  MeshBuilder builder("lamp");
  if (lights == 2) return builder.quad({-0.5f, y, -0.5f}, {0.5f, y, -0.5f}, {0.5f, y, 0.5f}, {-0.5f, y, 0.5f}).take();
  constexpr float spread = 3.6f;  // of the ceiling's 4 m, so that a cell is wider than a triangle is long
  const auto columns = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(lights)) - 1e-9));
  const float cell = spread / static_cast<float>(columns), leg = std::sqrt(2 / static_cast<float>(lights));
  const auto corner = [&](int index) {
    return -0.5f * spread + cell * (static_cast<float>(index) + 0.5f) - 0.5f * leg;
  };
  for (int light = 0; light < lights; ++light) {
    const float x = corner(light % columns), z = corner(light / columns);
    builder.triangle({x, y, z}, {x + leg, y, z}, {x + leg, y, z + leg});
  }
  return builder.take();
}

}  // namespace

Scene make_blocks(int triangles, int lights) {
  Scene scene;
  const int white = add_lambert(scene, "white", glm::vec3(0.7f));
  const int red = add_lambert(scene, "red", {0.6f, 0.15f, 0.12f}),
            green = add_lambert(scene, "green", {0.2f, 0.5f, 0.2f});
  const int walls[3][2] = {{red, green}, {white, white}, {white, white}};
  const char* names[3][2] = {{"wall -x", "wall +x"}, {"floor", "ceiling"}, {"wall -z", "wall +z"}};
  const int blocks = (triangles - faces_of_room) / faces_of_block;
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      const bool floor = axis == 1 && side == 0;
      add_instance(
          scene,
          add_mesh(scene, floor ? floor_fan(triangles - faces_of_room - blocks * faces_of_block)
                                : MeshBuilder(names[axis][side]).box_face(room_min, room_max, axis, side, true).take()),
          walls[axis][side]);
    }
  }
  add_instance(scene, add_mesh(scene, lamp_mesh(lights)), add_emitter(scene, "lamp", {15.f, 14.f, 12.f}));

  // One block in a cell of a grid; cells without one lie evenly between the others. A block turns within its cell.
  const int cells = static_cast<int>(std::ceil(std::cbrt(static_cast<double>(blocks)) - 1e-9));
  const glm::vec3 cell = (room_max - room_min - glm::vec3(0, 0.1f, 0)) / static_cast<float>(cells);
  const float edge = std::sqrt(blocks_area / (6 * static_cast<float>(blocks)));
  const int64_t places = int64_t{cells} * cells * cells;
  MeshBuilder builders[2] = {MeshBuilder("pale blocks"), MeshBuilder("blue blocks")};
  for (int block = 0; block < blocks; ++block) {
    const auto place = static_cast<int>(block * places / blocks);
    const glm::vec3 index(static_cast<float>(place % cells), static_cast<float>(place / cells % cells),
                          static_cast<float>(place / (cells * cells)));
    const glm::vec3 axis = glm::normalize(glm::vec3(random(block, 0), random(block, 1), random(block, 2)) + 0.01f);
    const glm::quat turn = glm::angleAxis(2 * glm::pi<float>() * random(block, 3), axis);
    const glm::vec3 centre = room_min + cell * (index + 0.5f);
    add_cube(builders[block % 2], centre, edge, turn);
  }
  add_instance(scene, add_mesh(scene, builders[0].take()), add_lambert(scene, "pale", {0.7f, 0.65f, 0.5f}));
  add_instance(scene, add_mesh(scene, builders[1].take()), add_lambert(scene, "blue", {0.2f, 0.3f, 0.6f}));
  scene.cameras.push_back(look_at_camera("front", {0.f, 1.5f, 1.95f}, {0.f, 1.4f, 0.f}, 75.f));
  scene.camera_paths.push_back(walk({{0, {0.f, 1.5f, 1.95f}, {0.f, 1.4f, 0.f}, 75.f},
                                     {1, {1.5f, 1.2f, 1.4f}, {-0.2f, 1.5f, -0.2f}, 75.f},
                                     {2, {1.4f, 2.4f, -1.5f}, {-0.3f, 1.1f, 0.2f}, 75.f},
                                     {3, {-1.7f, 1.9f, -1.5f}, {0.2f, 1.2f, 0.3f}, 75.f}}));
  return scene;
}

}  // namespace lucarium
