// SPDX-License-Identifier: Apache-2.0
// builtin:statue: a displaced ball in the corner of a room, with a point light close to it, as papers about virtual
// lights show it. Declared in builder.h.
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/quaternion.hpp>
#include <map>

#include "lucarium/scene/builtin/builder.h"

namespace lucarium {

namespace {

constexpr float kTurnSeconds = 4;

/// Distance of the surface from the centre along a unit direction: ridges around the vertical, and bumps.
float statue_radius(const glm::vec3& d) {
  const float phi = std::atan2(d.z, d.x);
  const float ridges = 0.12f * (1 - d.y * d.y) * std::cos(5 * phi + 3 * d.y);
  const float bumps = 0.05f * std::sin(9 * d.x) * std::sin(8 * d.y + 1) * std::sin(9 * d.z);
  return 0.34f * (1 + ridges + bumps);
}

/// Smooth: vertices of neighbouring triangles are joined, normals are averaged by area.
Mesh statue_mesh(int levels) {
  std::vector<glm::vec3> positions, normals;
  std::vector<glm::uvec3> triangles;
  const auto before = [](const glm::vec3& a, const glm::vec3& b) {
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
  };
  std::map<glm::vec3, uint32_t, decltype(before)> known(before);
  for (const std::array<glm::vec3, 3>& corners : icosphere(levels)) {
    glm::uvec3 triangle;
    for (int k = 0; k < 3; ++k) {
      const auto [found, added] = known.try_emplace(corners[k], static_cast<uint32_t>(positions.size()));
      if (added) {
        positions.push_back(statue_radius(corners[k]) * corners[k]);
        normals.emplace_back(0);
      }
      triangle[k] = found->second;
    }
    const glm::vec3 area =
        glm::cross(positions[triangle.y] - positions[triangle.x], positions[triangle.z] - positions[triangle.x]);
    for (int k = 0; k < 3; ++k) normals[triangle[k]] += area;
    triangles.push_back(triangle);
  }
  MeshBuilder builder("statue");
  for (size_t i = 0; i < positions.size(); ++i) builder.vertex(positions[i], normals[i]);
  for (const glm::uvec3& t : triangles) builder.face(t.x, t.y, t.z);
  return builder.take();
}

}  // namespace

Scene make_statue(int levels, int roughness) {
  Scene scene;
  const int white = add_lambert(scene, "white", {0.75f, 0.73f, 0.7f}),
            red = add_lambert(scene, "red", {0.6f, 0.2f, 0.15f});
  const int bronze = add_metal(scene, "bronze", {0.75f, 0.58f, 0.4f}, 0.01f * static_cast<float>(roughness));
  const glm::vec3 low(-0.7f, 0, -0.7f), high(1.5f, 2, 1.5f);
  const auto wall = [&](const char* name, int axis, int material) {
    add_instance(scene, add_mesh(scene, MeshBuilder(name).box_face(low, high, axis, 0, true).take()), material);
  };
  wall("floor", 1, white);
  wall("left wall", 0, red);
  wall("back wall", 2, white);
  const glm::vec3 place(-0.1f, 0.38f, -0.1f);
  const int node = add_node_instance(scene, add_mesh(scene, statue_mesh(levels)), bronze, place);

  Animation turn{.name = "turn", .channels = {}, .duration = kTurnSeconds};
  AnimationChannel rotation{.node = node, .path = AnimationPath::rotation, .times = {}, .values = {}};
  constexpr int keys = 17;
  for (int key = 0; key < keys; ++key) {
    const float part = static_cast<float>(key) / (keys - 1);
    const glm::quat q = glm::angleAxis(2 * glm::pi<float>() * part, glm::vec3(0, 1, 0));
    rotation.times.push_back(part * kTurnSeconds);
    rotation.values.insert(rotation.values.end(), {q.x, q.y, q.z, q.w});
  }
  turn.channels = {rotation};
  scene.animations.push_back(turn);

  // 3 cm off the surface, on the side of the corner.
  SceneLight light;
  light.name = "point";
  const glm::vec3 towards = glm::normalize(glm::vec3(-0.6f, 0.5f, -0.2f));
  light.world_from_light = frame_along(place + (statue_radius(towards) + 0.03f) * towards, {0, -1, 0});
  scene.lights.push_back(light);
  scene.cameras.push_back(look_at_camera("front", {1.35f, 1.25f, 1.45f}, {-0.15f, 0.5f, -0.15f}, 40.f));
  return scene;
}

}  // namespace lucarium
