// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/device/scene_layout.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/packing.hpp>
#include <limits>

#include "lucarium/base/error.h"
#include "lucarium/scene/deform.h"
#include "lucarium/scene/device/emission.h"
#include "lucarium/scene/device/texture_sampling.h"

namespace lucarium {

namespace {

float4 matrix_row(const glm::mat4& m, int row) { return {m[0][row], m[1][row], m[2][row], m[3][row]}; }
float4 matrix_row(const glm::mat3& m, int row) { return {m[0][row], m[1][row], m[2][row], 0.f}; }

TextureSlot pack_slot(const TextureUse& use) {
  const TextureTransform transform = texture_transform(use);
  TextureSlot slot{};
  slot.row_u = float4(transform.row_u, 0.f);
  slot.row_v = float4(transform.row_v, 0.f);
  slot.texture = use.texture == none ? LUCARIUM_NONE : static_cast<uint>(use.texture);
  slot.uv_set = static_cast<uint>(use.uv_set);
  slot.scale = use.strength;
  return slot;
}

/// Beer extinction per metre from KHR_materials_volume: white light becomes `color` after `distance`.
glm::vec3 extinction(const glm::vec3& color, float distance) {
  if (!std::isfinite(distance)) return glm::vec3(0);
  return -glm::log(glm::clamp(color, 1e-6f, 1.f)) / distance;
}

}  // namespace

bool is_flipped(const SceneInstance& instance) {
  return (glm::determinant(glm::dmat3(glm::mat3(instance.world_from_object))) < 0) != instance.mirrored;
}

void place_instance(Instance& record, const SceneInstance& instance) {
  const glm::mat4& m = instance.world_from_object;
  const glm::mat3 normals = normal_matrix(glm::mat3(m));
  record.row0 = matrix_row(m, 0), record.row1 = matrix_row(m, 1), record.row2 = matrix_row(m, 2);
  record.normal0 = matrix_row(normals, 0), record.normal1 = matrix_row(normals, 1);
  record.normal2 = matrix_row(normals, 2);
  record.flags =
      (is_flipped(instance) ? LUCARIUM_INSTANCE_FLIPPED : 0u) | (instance.pose ? LUCARIUM_INSTANCE_DEFORMED : 0u);
}

SceneLayout::SceneLayout(const Scene& scene) {
  std::vector<uint64_t> mesh_vertex(scene.meshes.size(), UINT64_MAX), mesh_triangle(scene.meshes.size(), UINT64_MAX);
  for (int i = 0; i < static_cast<int>(scene.instances.size()); ++i) {
    const SceneInstance& instance = scene.instances[i];
    const Mesh& mesh = scene.meshes[instance.mesh];
    if (mesh_triangle[instance.mesh] == UINT64_MAX) {
      mesh_triangle[instance.mesh] = mesh_triangles;
      mesh_triangles += mesh.triangles.size();
      meshes.push_back(instance.mesh);
    }
    uint64_t first_vertex = mesh_vertices;
    if (instance.pose || mesh_vertex[instance.mesh] == UINT64_MAX) {
      vertex_sources.push_back(
          {instance.pose ? none : instance.mesh, instance.pose ? i : none, static_cast<uint32_t>(mesh_vertices)});
      if (!instance.pose) mesh_vertex[instance.mesh] = mesh_vertices;
      mesh_vertices += mesh.positions.size();
    } else {
      first_vertex = mesh_vertex[instance.mesh];
    }
    Instance record{};
    place_instance(record, instance);
    record.mesh_vertex = static_cast<uint>(first_vertex);
    record.vertex_count = static_cast<uint>(mesh.positions.size());
    record.mesh_triangle = static_cast<uint>(mesh_triangle[instance.mesh]);
    record.triangle_count = static_cast<uint>(mesh.triangles.size());
    record.world_vertex = static_cast<uint>(world_vertices);
    record.world_triangle = static_cast<uint>(world_triangles);
    record.material = static_cast<uint>(instance.material);
    instances.push_back(record);
    world_vertices += mesh.positions.size();
    world_triangles += mesh.triangles.size();
  }
  const uint64_t largest = std::max({mesh_vertices, mesh_triangles, world_vertices, world_triangles});
  if (largest > std::numeric_limits<uint32_t>::max() - 1) {
    throw_error(ErrorClass::input, "{}: {} vertices or triangles are more than 32-bit indices can name", scene.source,
                largest);
  }
}

bool SceneLayout::fits(const Scene& scene) const {
  if (scene.instances.size() != instances.size()) return false;
  for (size_t i = 0; i < instances.size(); ++i) {
    const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
    const bool deformed = (instances[i].flags & LUCARIUM_INSTANCE_DEFORMED) != 0;
    if (deformed != (scene.instances[i].pose != nullptr) || mesh.positions.size() != instances[i].vertex_count ||
        mesh.triangles.size() != instances[i].triangle_count) {
      return false;
    }
  }
  return true;
}

std::vector<uint32_t> alpha_bits(const Scene& scene, const SceneLayout& layout) {
  std::vector<uint32_t> words((layout.world_triangles + 31) / 32);
  for (const Instance& instance : layout.instances) {
    if (scene.materials[instance.material].alpha_mode == AlphaMode::opaque) continue;
    const uint32_t end = instance.world_triangle + instance.triangle_count;
    for (uint32_t t = instance.world_triangle; t < end; ++t) words[t / 32] |= 1u << t % 32;
  }
  return words;
}

Vertex pack_vertex(const Mesh& mesh, size_t i) {
  constexpr float largest_half = 65504.f;
  const glm::vec2 uv0 = mesh.uv[0].empty() ? glm::vec2(0) : mesh.uv[0][i];
  const glm::vec2 uv1 = mesh.uv[1].empty() ? glm::vec2(0) : mesh.uv[1][i];
  const glm::vec4 color = mesh.colors.empty() ? glm::vec4(1) : glm::clamp(mesh.colors[i], 0.f, largest_half);
  Vertex vertex{};
  vertex.position = float4(mesh.positions[i], uv0.x);
  vertex.normal = float4(mesh.normals[i], uv0.y);
  if (!mesh.tangents.empty()) vertex.tangent = float4(mesh.tangents[i]);
  vertex.u1 = uv1.x, vertex.v1 = uv1.y;
  vertex.color_rg = glm::packHalf2x16({color.r, color.g});
  vertex.color_ba = glm::packHalf2x16({color.b, color.a});
  return vertex;
}

Material pack_material(const SceneMaterial& m, bool vertex_colors) {
  Material result{};
  result.base_color = float4(m.base_color);
  result.emission = float4(m.emissive_factor * m.emissive_strength, m.alpha_cutoff);
  result.metallic = m.metallic, result.roughness = m.roughness, result.transmission = m.transmission;
  result.ior = m.ior;
  result.attenuation = float4(extinction(m.attenuation_color, m.attenuation_distance), m.thickness);
  const auto flag = [](bool set, uint bit) { return set ? bit : 0u; };
  result.flags = flag(m.double_sided, LUCARIUM_MATERIAL_DOUBLE_SIDED) | flag(m.unlit, LUCARIUM_MATERIAL_UNLIT) |
                 flag(m.alpha_mode == AlphaMode::mask, LUCARIUM_MATERIAL_MASK) |
                 flag(m.alpha_mode == AlphaMode::blend, LUCARIUM_MATERIAL_BLEND) |
                 flag(m.thickness == 0, LUCARIUM_MATERIAL_THIN) |
                 flag(m.transmission > 0, LUCARIUM_MATERIAL_TRANSMISSIVE) |
                 flag(m.emits(), LUCARIUM_MATERIAL_EMISSIVE) | flag(vertex_colors, LUCARIUM_MATERIAL_VERTEX_COLOR);
  result.base_color_texture = pack_slot(m.base_color_texture);
  result.metallic_roughness_texture = pack_slot(m.metallic_roughness_texture);
  result.normal_texture = pack_slot(m.normal_texture);
  result.emissive_texture = pack_slot(m.emissive_texture);
  result.transmission_texture = pack_slot(m.transmission_texture);
  return result;
}

}  // namespace lucarium
