// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/deform.h"

#include <cmath>

namespace lucarium {

namespace {

glm::vec3 unit_or(const glm::vec3& v, const glm::vec3& otherwise) {
  const float length = glm::length(v);
  return length > 0 && std::isfinite(length) ? v / length : otherwise;
}

void add_scaled(std::vector<glm::vec3>& target, const std::vector<glm::vec3>& deltas, float weight) {
  const size_t count = std::min(target.size(), deltas.size());
  for (size_t i = 0; i < count; ++i) target[i] += weight * deltas[i];
}

}  // namespace

glm::mat3 normal_matrix(const glm::mat3& m) {
  const glm::dmat3 d(m);
  glm::dmat3 cofactors(glm::cross(d[1], d[2]), glm::cross(d[2], d[0]), glm::cross(d[0], d[1]));
  if (glm::dot(d[0], cofactors[0]) < 0) cofactors = -cofactors;
  // Only the direction matters: keep the entries near 1 whatever the scale of the instance.
  double largest = 0;
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) largest = std::max(largest, std::abs(cofactors[c][r]));
  }
  return largest > 0 ? glm::mat3(cofactors / largest) : glm::mat3(1.f);
}

void recompute_flat_normals(Mesh& mesh, bool reversed_winding) {
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::vec3 &a = mesh.positions[t.x], &b = mesh.positions[t.y], &c = mesh.positions[t.z];
    const glm::vec3 n = unit_or(glm::cross(b - a, c - a), glm::vec3(0));
    if (n == glm::vec3(0)) continue;
    mesh.normals[t.x] = mesh.normals[t.y] = mesh.normals[t.z] = reversed_winding ? -n : n;
  }
}

Mesh morph(const Mesh& mesh, const std::vector<float>& weights) {
  Mesh pose = mesh;
  pose.morph_targets.clear();
  std::vector<glm::vec3> tangents(mesh.tangents.begin(), mesh.tangents.end());
  for (size_t k = 0; k < std::min(weights.size(), mesh.morph_targets.size()); ++k) {
    if (weights[k] == 0) continue;
    const MorphTarget& target = mesh.morph_targets[k];
    add_scaled(pose.positions, target.positions, weights[k]);
    add_scaled(pose.normals, target.normals, weights[k]);
    add_scaled(tangents, target.tangents, weights[k]);
  }
  for (size_t i = 0; i < pose.normals.size(); ++i) pose.normals[i] = unit_or(pose.normals[i], mesh.normals[i]);
  for (size_t i = 0; i < tangents.size(); ++i) {
    pose.tangents[i] = glm::vec4(unit_or(tangents[i], glm::vec3(mesh.tangents[i])), mesh.tangents[i].w);
  }
  if (mesh.flat_normals) recompute_flat_normals(pose, false);
  return pose;
}

bool skin(Mesh& mesh, const std::vector<glm::mat4>& world_from_bind, const glm::mat4& fallback) {
  size_t mirrored = 0;
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    glm::mat4 m(0.f);
    float sum = 0;
    for (int k = 0; k < 4; ++k) {
      const float weight = mesh.weights[i][k];
      if (weight == 0) continue;
      m += weight * world_from_bind[mesh.joints[i][k]];
      sum += weight;
    }
    m = sum > 0 ? m / sum : fallback;
    const glm::mat3 linear(m);
    if (glm::determinant(linear) < 0) ++mirrored;
    mesh.positions[i] = glm::vec3(m * glm::vec4(mesh.positions[i], 1.f));
    if (!mesh.normals.empty()) mesh.normals[i] = unit_or(normal_matrix(linear) * mesh.normals[i], mesh.normals[i]);
    if (!mesh.tangents.empty()) {
      const glm::vec3 t(mesh.tangents[i]);
      mesh.tangents[i] = glm::vec4(unit_or(linear * t, t), mesh.tangents[i].w);
    }
  }
  const bool reversed = 2 * mirrored > mesh.positions.size();
  if (mesh.flat_normals) recompute_flat_normals(mesh, reversed);
  return reversed;
}

}  // namespace lucarium
