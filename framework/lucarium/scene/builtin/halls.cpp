// SPDX-License-Identifier: Apache-2.0
// Built-in scenes of one hall with what papers about global illumination like to show: many lamps, a textured lamp,
// glossy spheres. Declared in builder.h.
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "lucarium/scene/builtin/builder.h"

namespace lucarium {

namespace {

constexpr glm::vec3 hall_min{-2.f, 0.f, -2.f}, hall_max{2.f, 2.6f, 2.f};

/// Four pillars and two partitions, so that light must go around corners.
Mesh hall_furniture() {
  MeshBuilder builder("pillars");
  for (const float x : {-1.1f, 1.1f}) {
    for (const float z : {-1.1f, 0.9f}) builder.box({x - 0.15f, 0, z - 0.15f}, {x + 0.15f, 2.1f, z + 0.15f});
  }
  builder.box({-1.9f, 0, -0.35f}, {-1.25f, 1.3f, -0.25f});
  builder.box({1.25f, 0, -0.35f}, {1.9f, 1.3f, -0.25f});
  return builder.take();
}

/// The closed hall, a different colour on each side.
void add_hall(Scene& scene) {
  const int white = add_lambert(scene, "white", glm::vec3(0.75f));
  const int walls[3][2] = {
      {add_lambert(scene, "red", {0.65f, 0.2f, 0.15f}), add_lambert(scene, "green", {0.2f, 0.5f, 0.25f})},
      {add_lambert(scene, "floor", {0.55f, 0.5f, 0.45f}), white},
      {white, white}};
  const char* names[3][2] = {{"wall -x", "wall +x"}, {"floor", "ceiling"}, {"wall -z", "wall +z"}};
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      const Mesh face = MeshBuilder(names[axis][side]).box_face(hall_min, hall_max, axis, side, true).take();
      add_instance(scene, add_mesh(scene, face), walls[axis][side]);
    }
  }
  scene.cameras.push_back(look_at_camera("front", {0.f, 1.5f, 1.9f}, {0.f, 1.1f, -0.5f}, 62.f));
}

Mesh faceted_sphere(const std::string& name, int levels, float radius) {
  MeshBuilder builder(name);
  for (const auto& [a, b, c] : icosphere(levels)) builder.triangle(radius * a, radius * b, radius * c);
  return builder.take();
}

/// A smooth sphere of `rows` by 2 `rows` quads with texture coordinates: u around, v from the north pole down.
Mesh mapped_sphere(const std::string& name, float radius, int rows) {
  MeshBuilder builder(name);
  std::vector<glm::vec2> uv;
  const int columns = 2 * rows;
  for (int row = 0; row <= rows; ++row) {
    for (int column = 0; column <= columns; ++column) {
      const glm::vec2 at(static_cast<float>(column) / static_cast<float>(columns),
                         static_cast<float>(row) / static_cast<float>(rows));
      const float theta = glm::pi<float>() * at.y, phi = 2 * glm::pi<float>() * at.x;
      const glm::vec3 normal(std::sin(theta) * std::cos(phi), std::cos(theta), -std::sin(theta) * std::sin(phi));
      builder.vertex(radius * normal, normal);
      uv.push_back(at);
    }
  }
  const auto index = [&](int row, int column) { return static_cast<uint32_t>(row * (columns + 1) + column); };
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      if (row + 1 < rows) builder.face(index(row, column), index(row + 1, column), index(row + 1, column + 1));
      if (row > 0) builder.face(index(row, column), index(row + 1, column + 1), index(row, column + 1));
    }
  }
  Mesh mesh = builder.take();
  mesh.uv[0] = std::move(uv);
  return mesh;
}

/// Patches of saturated light, four by four, none of them black.
Image lamp_pattern() {
  constexpr uint32_t size = 64, patch = 16;
  constexpr uint8_t colors[4][3] = {{255, 235, 190}, {235, 70, 40}, {60, 110, 235}, {70, 200, 90}};
  Image image;
  image.name = "patches";
  image.width = image.height = size;
  for (uint32_t y = 0; y < size; ++y) {
    for (uint32_t x = 0; x < size; ++x) {
      const uint8_t* color = colors[(x / patch + 2 * (y / patch)) % 4];
      image.rgba.insert(image.rgba.end(), {color[0], color[1], color[2], 255});
    }
  }
  return image;
}

}  // namespace

Scene make_lamps(int count) {
  // Equal total area and radiance: the same light, more or less spread out.
  Scene scene;
  add_hall(scene);
  add_instance(scene, add_mesh(scene, hall_furniture()), 0);
  const int lamp = add_emitter(scene, "lamp", glm::vec3(24.f, 20.f, 15.f));
  const int mesh = add_mesh(scene, faceted_sphere("lamp", 1, 0.25f / std::sqrt(static_cast<float>(count))));
  const int columns = static_cast<int>(std::ceil(std::sqrt(static_cast<float>(count)))),
            rows = (count + columns - 1) / columns;
  const auto spread = [](int i, int n) {
    return 3.2f * ((static_cast<float>(i) + 0.5f) / static_cast<float>(n) - 0.5f);
  };
  for (int i = 0; i < count; ++i) {
    const glm::vec3 place(spread(i % columns, columns), 2.25f, spread(i / columns, rows));
    add_instance(scene, mesh, lamp, glm::translate(glm::mat4(1.f), place));
  }
  return scene;
}

Scene make_picture_lamp() {
  Scene scene;
  add_hall(scene);
  add_instance(scene, add_mesh(scene, hall_furniture()), 0);
  const int lamp = add_emitter(scene, "picture", glm::vec3(30.f));
  scene.images.push_back(lamp_pattern());
  scene.textures.push_back({.image = 0, .srgb = true});
  scene.materials[lamp].emissive_texture.texture = 0;
  add_instance(scene, add_mesh(scene, mapped_sphere("picture", 0.3f, 16)), lamp,
               glm::translate(glm::mat4(1.f), glm::vec3(0.f, 1.2f, -0.6f)));
  return scene;
}

Scene make_spheres() {
  Scene scene;
  add_hall(scene);
  const int lamp = add_emitter(scene, "lamp", glm::vec3(14.f, 13.f, 11.f));
  for (const float x : {-1.f, 1.f}) {
    add_instance(scene,
                 add_mesh(scene, MeshBuilder("lamp")
                                     .quad({x - 0.4f, 2.59f, -0.9f}, {x + 0.4f, 2.59f, -0.9f}, {x + 0.4f, 2.59f, 0.3f},
                                           {x - 0.4f, 2.59f, 0.3f})
                                     .take()),
                 lamp);
  }
  const int sphere = add_mesh(scene, mapped_sphere("sphere", 0.5f, 48));
  const auto add_sphere = [&](int material, const glm::vec3& centre, float radius) {
    add_instance(scene, sphere, material, glm::scale(glm::translate(glm::mat4(1.f), centre), glm::vec3(2 * radius)));
  };
  add_sphere(add_metal(scene, "gold", {0.8f, 0.6f, 0.3f}, 0.4f), {-0.75f, 0.5f, -0.6f}, 0.5f);
  add_sphere(add_metal(scene, "silver", {0.8f, 0.8f, 0.8f}, 0.3f), {0.5f, 0.6f, -0.9f}, 0.6f);
  add_sphere(add_dielectric(scene, "porcelain", {0.7f, 0.7f, 0.75f}, 0.4f), {0.1f, 0.3f, 0.25f}, 0.3f);
  return scene;
}

}  // namespace lucarium
