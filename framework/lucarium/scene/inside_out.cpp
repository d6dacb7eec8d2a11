// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/inside_out.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "lucarium/scene/mesh_components.h"
#include "lucarium/scene/mesh_topology.h"

namespace lucarium {
namespace {

/// How often the mesh winds about a point: ±1 inside of a closed one, 0 outside. Solid angles of its triangles after
/// van Oosterom and Strackee, "The Solid Angle of a Plane Triangle", IEEE Trans. Biomed. Eng. 30(2), 1983, equation 8.
double winding_number(const Mesh& mesh, const glm::dvec3& point) {
  double angle = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a = glm::dvec3(mesh.positions[t.x]) - point, b = glm::dvec3(mesh.positions[t.y]) - point,
                     c = glm::dvec3(mesh.positions[t.z]) - point;
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    angle += 2 * std::atan2(glm::dot(a, glm::cross(b, c)),
                            la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
  }
  return angle / (4 * glm::pi<double>());
}

bool is_inside_out(const Scene& scene, const SceneInstance& instance) {
  const SceneMaterial& material = scene.materials[instance.material];
  if (material.double_sided || material.transmission > 0 || material.alpha_mode == AlphaMode::blend) return false;
  const Mesh& shape = instance.shape(scene);
  if (shape.triangles.empty()) return false;
  // A reflecting matrix turns the triangles over when they are derived, a mirrored skin does not.
  const double sign = instance.mirrored ? -1 : 1;
  if (!(sign * signed_volume(shape.positions, shape.triangles) < 0) || !is_closed(shape.positions, shape.triangles))
    return false;
  const glm::dmat4 world_from_object(instance.world_from_object);
  if (scene.cameras.empty() || glm::determinant(world_from_object) == 0) return true;
  const glm::dvec4 eye(glm::dvec3(scene.cameras.front().world_from_camera[3]), 1);
  return std::abs(winding_number(shape, glm::dvec3(glm::inverse(world_from_object) * eye))) < 0.5;
}

}  // namespace

std::vector<std::string> meshes_inside_out(const Scene& scene) {
  std::vector<std::string> names;
  for (const SceneInstance& instance : scene.instances) {
    if (!is_inside_out(scene, instance)) continue;
    const std::string& name = scene.meshes[instance.mesh].name;
    const std::string shown = name.empty() ? scene.materials[instance.material].name : name;
    if (std::find(names.begin(), names.end(), shown) == names.end()) names.push_back(shown);
  }
  return names;
}

}  // namespace lucarium
