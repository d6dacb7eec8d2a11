// SPDX-License-Identifier: Apache-2.0
// The unit box with a lamp in its ceiling and one wall of mirror: its mean irradiance by a path tracer of its own, in
// double precision.
//
// Path of a texel's point: cosine-distributed directions, so that every bounce weighs by the albedo alone. At diffuse
// places the lamp's light is added in closed form (Lambert 1760: light of a polygon); the mirror turns the path and
// weighs it by its reflectance, and behind it the lamp's own radiance is added, which no closed form has brought.
#pragma once
#include <array>
#include <cmath>
#include <random>

#include "field_rig.h"
#include "lucarium/base/numbers.h"

namespace lucarium::test {

struct LampBox {
  std::array<double, 6> albedo{0.25, 0.9, 0.6, 0.7, 0.7, 0.5};  ///< -x, +x, -y, +y, -z, +z
  bool mirror = true;                                           ///< the wall +x reflects ideally, or diffusely
  double lamp_x[2] = {0.375, 0.625}, lamp_z[2] = {0.375, 0.625};
  double radiance = 20;

  /// Walls, then the lamp, which fills a hole of the ceiling and has its albedo.
  Scene scene() const {
    std::vector<std::pair<int, SceneMaterial>> walls;
    for (const int wall : {0, 1, 2, 4, 5}) {
      const auto rho = static_cast<float>(albedo[static_cast<size_t>(wall)]);
      walls.emplace_back(wall, wall == 1 && mirror ? test::mirror(rho) : lambert(rho));
    }
    Scene scene = unit_box(walls);
    const auto ceiling = static_cast<float>(albedo[3]);
    Mesh& frame = scene.meshes.emplace_back();
    frame.flat_normals = true;
    const int grey = add_material(scene, lambert(ceiling));
    frame.material = grey;
    const std::array<double, 4> x{0, lamp_x[0], lamp_x[1], 1}, z{0, lamp_z[0], lamp_z[1], 1};
    for (size_t i = 0; i < 3; ++i)
      for (size_t j = 0; j < 3; ++j)
        if ((i != 1 || j != 1) && x[i] < x[i + 1] && z[j] < z[j + 1])
          add_rectangle(frame, x[i], x[i + 1], z[j], z[j + 1]);
    SceneInstance instance;
    instance.mesh = static_cast<int>(scene.meshes.size()) - 1;
    instance.material = grey;
    scene.instances.push_back(instance);
    Mesh lamp;
    lamp.flat_normals = true;
    lamp.material = add_material(scene, emitter(static_cast<float>(radiance), ceiling));
    add_rectangle(lamp, x[1], x[2], z[1], z[2]);
    scene.meshes.push_back(lamp);
    instance.mesh = static_cast<int>(scene.meshes.size()) - 1;
    instance.material = lamp.material;
    scene.instances.push_back(instance);
    return scene;
  }
  /// Instances of the scene: -x, +x, -y, -z, +z, frame of the ceiling, lamp.
  static constexpr int kFloor = 2, kCeiling = 5, kLamp = 6;

  /// Mean irradiance over pi of a wall; of the ceiling without the lamp.
  double mean(int wall, int paths, std::mt19937_64& random) const {
    double sum = 0;
    for (int i = 0; i < paths; ++i) {
      glm::dvec3 p;
      do {
        p[wall / 2] = wall % 2;
        p[(wall / 2 + 1) % 3] = unit(random);
        p[(wall / 2 + 2) % 3] = unit(random);
      } while (wall == 3 && on_lamp(p));
      sum += path(p, wall, random);
    }
    return sum / paths;
  }

 private:
  static double unit(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }
  bool on_lamp(const glm::dvec3& p) const {
    return p.x > lamp_x[0] && p.x < lamp_x[1] && p.z > lamp_z[0] && p.z < lamp_z[1];
  }

  /// Irradiance over pi at a wall's point by the lamp itself.
  double lamp_light(const glm::dvec3& p, int wall) const {
    if (wall == 3) return 0;
    glm::dvec3 n(0), to[4];
    n[wall / 2] = wall % 2 ? -1 : 1;
    for (int i = 0; i < 4; ++i) to[i] = glm::normalize(glm::dvec3(lamp_x[i == 1 || i == 2], 1, lamp_z[i >= 2]) - p);
    double sum = 0;
    for (int i = 0; i < 4; ++i) {
      const glm::dvec3 across = glm::cross(to[i], to[(i + 1) % 4]);
      const double length = glm::length(across);
      if (length > 0) sum += std::atan2(length, glm::dot(to[i], to[(i + 1) % 4])) * glm::dot(across, n) / length;
    }
    return radiance * std::abs(sum) / (2 * pi);
  }

  /// One path's irradiance over pi: at its first point the lamp, then what comes from elsewhere.
  double path(glm::dvec3 p, int wall, std::mt19937_64& random) const {
    double sum = lamp_light(p, wall), factor = 1;
    glm::dvec3 d = cosine_direction(wall, random);
    bool turned = false;
    for (;;) {
      p = next(p, d, &wall);
      if (wall == 1 && mirror) {
        const double cosine = std::abs(d.x), rest = 1 - albedo[1];  // Schlick's Fresnel term of a metal
        factor *= albedo[1] + rest * std::pow(1 - cosine, 5);
        d.x = -d.x;
        turned = true;
        continue;
      }
      if (turned && wall == 3 && on_lamp(p)) sum += factor * radiance;
      factor *= albedo[static_cast<size_t>(wall)];
      sum += factor * lamp_light(p, wall);
      if (factor < 0.1) {
        if (unit(random) >= 0.5) return sum;
        factor *= 2;
      }
      d = cosine_direction(wall, random);
      turned = false;
    }
  }

  static glm::dvec3 cosine_direction(int wall, std::mt19937_64& random) {
    const double square = unit(random), phi = 2 * pi * unit(random), r = std::sqrt(square), up = std::sqrt(1 - square);
    const int axis = wall / 2;
    glm::dvec3 d;
    d[axis] = wall % 2 ? -up : up;
    d[(axis + 1) % 3] = r * std::cos(phi);
    d[(axis + 2) % 3] = r * std::sin(phi);
    return d;
  }

  static glm::dvec3 next(const glm::dvec3& p, const glm::dvec3& d, int* wall) {
    double nearest = 1e30;
    const int from = *wall;
    for (int axis = 0; axis < 3; ++axis) {
      const int reached = 2 * axis + (d[axis] > 0);
      if (reached == from || std::abs(d[axis]) < 1e-12) continue;
      const double t = ((d[axis] > 0 ? 1. : 0.) - p[axis]) / d[axis];
      if (t >= nearest) continue;
      nearest = t;
      *wall = reached;
    }
    return p + nearest * d;
  }

  static void add_rectangle(Mesh& mesh, double x0, double x1, double z0, double z1) {
    const auto base = static_cast<uint32_t>(mesh.positions.size());
    for (const glm::dvec2 c : {glm::dvec2(x0, z0), glm::dvec2(x1, z0), glm::dvec2(x1, z1), glm::dvec2(x0, z1)}) {
      mesh.positions.emplace_back(static_cast<float>(c.x), 1.f, static_cast<float>(c.y));
      mesh.normals.emplace_back(0.f, -1.f, 0.f);
    }
    mesh.triangles.push_back({base, base + 1, base + 2});
    mesh.triangles.push_back({base, base + 2, base + 3});
  }
};

}  // namespace lucarium::test
