// SPDX-License-Identifier: Apache-2.0
// Scenes made by hand: flat polygons, boxes, spheres, lights and cameras.
#pragma once
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <utility>
#include <vector>

#include "lucarium/scene/scene.h"

namespace lucarium::test {

/// No Fresnel interface (ior 1): exactly Lambertian with albedo `rho`.
inline SceneMaterial lambert(float rho) {
  SceneMaterial material;
  material.base_color = glm::vec4(rho, rho, rho, 1);
  material.metallic = 0;
  material.roughness = 1;
  material.ior = 1;
  return material;
}

inline SceneMaterial emitter(float radiance, float rho = 0) {
  SceneMaterial material = lambert(rho);
  material.emissive_factor = glm::vec3(1);
  material.emissive_strength = radiance;
  return material;
}

/// A solid of ideal glass, index 1.5.
inline SceneMaterial clear_glass() {
  SceneMaterial material;
  material.metallic = 0;
  material.roughness = 0;
  material.transmission = 1;
  material.thickness = 1;
  return material;
}

inline int add_material(Scene& scene, const SceneMaterial& material) {
  scene.materials.push_back(material);
  return static_cast<int>(scene.materials.size()) - 1;
}

/// Flat triangles, three positions each, counter-clockwise seen from the front.
inline void add_triangles(Scene& scene, const std::vector<glm::vec3>& positions, int material) {
  Mesh mesh;
  mesh.positions = positions;
  mesh.material = material;
  mesh.flat_normals = true;
  for (uint32_t i = 0; i < positions.size(); i += 3) {
    const glm::vec3 n = glm::normalize(glm::cross(positions[i + 1] - positions[i], positions[i + 2] - positions[i]));
    mesh.normals.insert(mesh.normals.end(), 3, n);
    mesh.triangles.push_back({i, i + 1, i + 2});
  }
  scene.meshes.push_back(std::move(mesh));
  SceneInstance instance;
  instance.mesh = static_cast<int>(scene.meshes.size()) - 1;
  instance.material = material;
  scene.instances.push_back(instance);
}

/// A convex polygon as a fan, counter-clockwise seen from its front.
inline void add_polygon(Scene& scene, const std::vector<glm::vec3>& corners, int material) {
  std::vector<glm::vec3> positions;
  for (size_t i = 2; i < corners.size(); ++i)
    positions.insert(positions.end(), {corners[0], corners[i - 1], corners[i]});
  add_triangles(scene, positions, material);
}

/// A horizontal rectangle about (x, z) at height y that faces up or down.
inline void add_horizontal(Scene& scene, float x, float y, float z, float size_x, float size_z, bool faces_up,
                           int material) {
  const float a = 0.5f * size_x, b = 0.5f * size_z;
  std::vector<glm::vec3> corners = {{x - a, y, z + b}, {x + a, y, z + b}, {x + a, y, z - b}, {x - a, y, z - b}};
  if (!faces_up) std::swap(corners[1], corners[3]);
  add_polygon(scene, corners, material);
}

/// Thin triangles through the whole scene, parallel to its axes: `width` at the middle of their length [m]. Rays cannot
/// hit those of width 0.
inline void add_threads(Scene& scene, int count, float width, int material) {
  const Bounds bounds = scene.bounds();
  Mesh mesh;
  mesh.material = material;
  for (int i = 0; i < count; ++i) {
    const int along = i % 3, across = (i + 1) % 3;
    const float at = (static_cast<float>(i) + 0.5f) / static_cast<float>(count);
    glm::vec3 a = bounds.min + at * (bounds.max - bounds.min), b = a, c = a;
    b[along] = bounds.max[along];
    a[along] = bounds.min[along];
    c[across] += width;
    mesh.positions.insert(mesh.positions.end(), {a, b, c});
    glm::vec3 normal(0);
    normal[3 - along - across] = 1;
    mesh.normals.insert(mesh.normals.end(), 3, normal);
    const auto first = static_cast<uint32_t>(3 * i);
    mesh.triangles.emplace_back(first, first + 1, first + 2);
  }
  scene.meshes.push_back(std::move(mesh));
  SceneInstance instance;
  instance.mesh = static_cast<int>(scene.meshes.size()) - 1;
  instance.material = material;
  scene.instances.push_back(instance);
}

/// Regular polygon with `sides` sides whose area is that of the disk of this radius.
inline std::vector<glm::vec3> disk_corners(float y, float radius, int sides, bool faces_up) {
  const double step = 2 * M_PI / sides;
  const double scaled = radius * std::sqrt(step / std::sin(step));
  std::vector<glm::vec3> corners;
  for (int i = 0; i < sides; ++i) {
    const double angle = (faces_up ? -i : i) * step;
    corners.push_back({scaled * std::cos(angle), y, scaled * std::sin(angle)});
  }
  return corners;
}

/// The walls of an axis-aligned box.
inline void add_box(Scene& scene, const glm::vec3& low, const glm::vec3& high, bool faces_inward, int material) {
  const auto corner = [&](int i) {
    return glm::vec3(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z);
  };
  const int faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (const auto& face : faces) {
    std::vector<glm::vec3> corners = {corner(face[0]), corner(face[1]), corner(face[2]), corner(face[3])};
    if (faces_inward) std::swap(corners[1], corners[3]);
    add_polygon(scene, corners, material);
  }
}

/// Triangles of an octahedron subdivided `levels` times and pushed out to the sphere; flat.
inline std::vector<glm::vec3> sphere_triangles(const glm::vec3& center, float radius, int levels, bool faces_inward) {
  std::vector<glm::dvec3> positions;
  for (int octant = 0; octant < 8; ++octant) {
    const glm::dvec3 x(octant & 1 ? -1 : 1, 0, 0), y(0, octant & 2 ? -1 : 1, 0), z(0, 0, octant & 4 ? -1 : 1);
    const bool mirrored = ((octant & 1) + ((octant >> 1) & 1) + ((octant >> 2) & 1)) % 2 == 1;
    if (mirrored != faces_inward)
      positions.insert(positions.end(), {x, z, y});
    else
      positions.insert(positions.end(), {x, y, z});
  }
  for (int level = 0; level < levels; ++level) {
    std::vector<glm::dvec3> finer;
    for (size_t i = 0; i < positions.size(); i += 3) {
      const glm::dvec3 &a = positions[i], &b = positions[i + 1], &c = positions[i + 2];
      const glm::dvec3 ab = glm::normalize(a + b), bc = glm::normalize(b + c), ca = glm::normalize(c + a);
      finer.insert(finer.end(), {a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca});
    }
    positions = std::move(finer);
  }
  std::vector<glm::vec3> result;
  for (const glm::dvec3& p : positions) result.push_back(center + radius * glm::vec3(p));
  return result;
}

inline void add_light(Scene& scene, LightType type, float intensity, const glm::vec3& position,
                      const glm::vec3& towards) {
  SceneLight light;
  light.type = type;
  light.intensity = glm::vec3(intensity);
  const glm::vec3 up = std::abs(glm::normalize(towards - position).y) > 0.9f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
  light.world_from_light = glm::inverse(glm::lookAt(position, towards, up));
  scene.lights.push_back(light);
}

inline void set_environment(Scene& scene, float radiance) {
  scene.environment.emplace();
  scene.environment->factor = glm::vec3(radiance);
}

/// An orthographic camera that looks at `target` from `eye`; half extents `half` [m].
inline SceneCamera look_orthographic(const glm::vec3& eye, const glm::vec3& target, float half) {
  SceneCamera camera;
  camera.perspective = false;
  camera.xmag = camera.ymag = half;
  const glm::vec3 up = std::abs(glm::normalize(target - eye).y) > 0.9f ? glm::vec3(0, 0, -1) : glm::vec3(0, 1, 0);
  camera.world_from_camera = glm::inverse(glm::lookAt(eye, target, up));
  return camera;
}

inline SceneCamera look_perspective(const glm::vec3& eye, const glm::vec3& target, float yfov) {
  SceneCamera camera = look_orthographic(eye, target, 1);
  camera.perspective = true;
  camera.yfov = yfov;
  return camera;
}

}  // namespace lucarium::test
