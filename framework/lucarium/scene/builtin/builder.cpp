// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/builtin/builder.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

namespace lucarium {

namespace {

bool has_area(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
  const glm::vec3 ab = b - a, ac = c - a, bc = c - b;
  const float longest = std::max({glm::dot(ab, ab), glm::dot(ac, ac), glm::dot(bc, bc)});
  return glm::length(glm::cross(ab, ac)) > 1e-6f * longest;
}

int add_material(Scene& scene, SceneMaterial material) {
  scene.materials.push_back(std::move(material));
  return static_cast<int>(scene.materials.size()) - 1;
}

}  // namespace

uint32_t MeshBuilder::vertex(const glm::vec3& position, const glm::vec3& normal) {
  mesh_.positions.push_back(position);
  mesh_.normals.push_back(glm::normalize(normal));
  return static_cast<uint32_t>(mesh_.positions.size()) - 1;
}

MeshBuilder& MeshBuilder::face(uint32_t a, uint32_t b, uint32_t c) {
  const std::vector<glm::vec3>& p = mesh_.positions;
  if (has_area(p[a], p[b], p[c])) mesh_.triangles.emplace_back(a, b, c);
  return *this;
}

MeshBuilder& MeshBuilder::triangle(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
  if (!has_area(a, b, c)) return *this;
  const glm::vec3 n = glm::cross(b - a, c - a);
  const uint32_t first = vertex(a, n);
  vertex(b, n), vertex(c, n);
  mesh_.triangles.emplace_back(first, first + 1, first + 2);
  return *this;
}

MeshBuilder& MeshBuilder::quad(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d) {
  if (!has_area(a, b, c) || !has_area(a, c, d)) return triangle(a, b, c).triangle(a, c, d);
  const glm::vec3 n = glm::cross(c - a, d - b);
  const uint32_t first = vertex(a, n);
  vertex(b, n), vertex(c, n), vertex(d, n);
  mesh_.triangles.emplace_back(first, first + 1, first + 2);
  mesh_.triangles.emplace_back(first, first + 2, first + 3);
  return *this;
}

MeshBuilder& MeshBuilder::box_face(const glm::vec3& min, const glm::vec3& max, int axis, int side, bool inwards) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  glm::vec3 corner[4];
  for (int i = 0; i < 4; ++i) {
    corner[i][axis] = side ? max[axis] : min[axis];
    corner[i][u] = (i == 1 || i == 2) ? max[u] : min[u];
    corner[i][v] = i >= 2 ? max[v] : min[v];
  }
  // The order 0 1 2 3 is counter-clockwise seen from the positive axis.
  if ((side == 1) != inwards) return quad(corner[0], corner[1], corner[2], corner[3]);
  return quad(corner[3], corner[2], corner[1], corner[0]);
}

MeshBuilder& MeshBuilder::box(const glm::vec3& min, const glm::vec3& max) {
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) box_face(min, max, axis, side, false);
  }
  return *this;
}

MeshBuilder& MeshBuilder::prism(const std::vector<glm::vec2>& polygon_xz, float bottom, float top) {
  const size_t n = polygon_xz.size();
  const auto at = [&](size_t i, float y) { return glm::vec3(polygon_xz[i % n].x, y, polygon_xz[i % n].y); };
  for (size_t i = 0; i < n; ++i) quad(at(i, bottom), at(i + 1, bottom), at(i + 1, top), at(i, top));
  for (size_t i = 1; i + 1 < n; ++i) {
    triangle(at(0, top), at(i, top), at(i + 1, top));
    triangle(at(0, bottom), at(i + 1, bottom), at(i, bottom));
  }
  return *this;
}

int add_lambert(Scene& scene, const std::string& name, const glm::vec3& albedo) {
  SceneMaterial material;
  material.name = name;
  material.base_color = glm::vec4(albedo, 1.f);
  material.metallic = 0;
  material.roughness = 1;
  material.ior = 1;
  return add_material(scene, material);
}

int add_emitter(Scene& scene, const std::string& name, const glm::vec3& radiance) {
  SceneMaterial material;
  material.name = name;
  material.base_color = glm::vec4(0, 0, 0, 1);
  material.metallic = 0;
  material.roughness = 1;
  material.ior = 1;
  const float strength = std::max({radiance.r, radiance.g, radiance.b});
  material.emissive_factor = radiance / strength;
  material.emissive_strength = strength;
  return add_material(scene, material);
}

int add_metal(Scene& scene, const std::string& name, const glm::vec3& color, float roughness) {
  SceneMaterial material;
  material.name = name;
  material.base_color = glm::vec4(color, 1.f);
  material.metallic = 1;
  material.roughness = roughness;
  return add_material(scene, material);
}

int add_dielectric(Scene& scene, const std::string& name, const glm::vec3& color, float roughness) {
  SceneMaterial material;
  material.name = name;
  material.base_color = glm::vec4(color, 1.f);
  material.metallic = 0;
  material.roughness = roughness;
  return add_material(scene, material);
}

int add_mesh(Scene& scene, Mesh mesh) {
  scene.meshes.push_back(std::move(mesh));
  return static_cast<int>(scene.meshes.size()) - 1;
}

void add_instance(Scene& scene, int mesh, int material, const glm::mat4& world_from_object) {
  SceneInstance instance;
  instance.mesh = mesh;
  instance.material = material;
  instance.world_from_object = world_from_object;
  scene.instances.push_back(instance);
}

int add_node_instance(Scene& scene, int mesh, int material, const glm::vec3& position) {
  const int index = static_cast<int>(scene.nodes.size());
  Node node;
  node.name = scene.meshes[mesh].name;
  node.translation = position;
  node.meshes = {mesh};
  scene.nodes.push_back(node);
  add_instance(scene, mesh, material);
  scene.instances.back().node = index;
  return index;
}

Environment clear_sky(float strength) {
  Environment environment;
  environment.name = "clear sky";
  environment.width = 128, environment.height = 64;
  for (uint32_t j = 0; j < environment.height; ++j) {
    const float up =
        std::cos(glm::pi<float>() * (static_cast<float>(j) + 0.5f) / static_cast<float>(environment.height));
    const glm::vec3 horizon(1.05f, 1.15f, 1.30f), zenith(0.28f, 0.55f, 1.15f), ground(0.22f, 0.20f, 0.18f);
    const glm::vec3 color = up > 0 ? glm::mix(horizon, zenith, std::pow(up, 0.5f)) : ground;
    environment.radiance.insert(environment.radiance.end(), environment.width, strength * color);
  }
  return environment;
}

CameraPath walk(const std::vector<CameraKey>& keys) {
  return {.name = "walk", .interpolation = CameraPath::Interpolation::spline, .keys = keys};
}

}  // namespace lucarium
