// SPDX-License-Identifier: Apache-2.0
#include "room.h"

#include <random>

#include "lucarium/scene/builtin/builder.h"

namespace lucarium::bench {

Scene make_full_room() {
  Scene scene;
  const int white = add_lambert(scene, "white", glm::vec3(0.7f));
  std::mt19937 engine(1);
  const auto uniform = [&](float low, float high) { return std::uniform_real_distribution<float>(low, high)(engine); };
  const glm::vec3 size(10, 4, 8);
  MeshBuilder walls("walls");
  constexpr int steps = 20;
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side)
      for (int i = 0; i < steps * steps; ++i) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        const auto corner = [&](int du, int dv) {
          glm::vec3 p;
          p[axis] = side ? size[axis] : 0.f;
          p[u] = size[u] * static_cast<float>(i % steps + du) / steps;
          p[v] = size[v] * static_cast<float>(i / steps + dv) / steps;
          return p;
        };
        if (side)
          walls.quad(corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0));
        else
          walls.quad(corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1));
      }
  add_instance(scene, add_mesh(scene, walls.take()), white);
  const auto inside = [&](float radius) {
    return glm::vec3(uniform(radius, size.x - radius), uniform(radius, size.y - radius),
                     uniform(radius, size.z - radius));
  };
  MeshBuilder spheres("spheres"), boxes("boxes");
  for (int i = 0; i < 48; ++i) {
    const float radius = uniform(0.15f, 0.6f);
    const glm::vec3 center = inside(radius);
    for (const auto& face : icosphere(3))
      spheres.triangle(center + radius * face[0], center + radius * face[1], center + radius * face[2]);
  }
  for (int i = 0; i < 330; ++i) {
    const glm::vec3 half(uniform(0.05f, 0.4f), uniform(0.05f, 0.4f), uniform(0.05f, 0.4f)), center = inside(0.4f);
    boxes.box(center - half, center + half);
  }
  add_instance(scene, add_mesh(scene, spheres.take()), white);
  add_instance(scene, add_mesh(scene, boxes.take()), white);
  return scene;
}

}  // namespace lucarium::bench
