// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <vector>

#include "lucarium/scene/scene.h"
#include "lucarium/shared/scene_types.h"

namespace lucarium {

/// Where meshes and instances lie in the device's arrays. Instances of one mesh share its object-space ranges;
/// deformed ones have vertices of their own (their pose) and share the triangles. World-space ranges follow the order
/// of instances and, inside one, of the mesh.
struct SceneLayout {
  struct VertexSource {
    int mesh = none;      ///< whose vertices, or
    int instance = none;  ///< whose pose
    uint32_t first = 0;   ///< in scene_mesh_vertices
  };
  std::vector<VertexSource> vertex_sources;
  std::vector<int> meshes;          ///< that are used, in the order of their triangles in scene_mesh_triangles
  std::vector<Instance> instances;  ///< one record per instance of the scene, complete
  uint64_t mesh_vertices = 0, mesh_triangles = 0, world_vertices = 0, world_triangles = 0;

  /// Throws Error{input} when an index would not fit into 32 bits.
  explicit SceneLayout(const Scene& scene);
  /// Whether `scene` still has this layout (same meshes and instances, deformed ones as before).
  bool fits(const Scene& scene) const;
};

/// scene_alpha: bit t mod 32 of word t / 32 says whether the material of world triangle t is MASK or BLEND.
std::vector<uint32_t> alpha_bits(const Scene& scene, const SceneLayout& layout);

/// Whether triangles of the mesh have their corners exchanged on the device, so that they stay counter-clockwise from
/// the front.
bool is_flipped(const SceneInstance& instance);

/// Sets transform, normal transform and flags of a record.
void place_instance(Instance& record, const SceneInstance& instance);

/// One vertex with its attributes; missing texture coordinates are 0, missing colours white, missing tangents 0.
Vertex pack_vertex(const Mesh& mesh, size_t index);

Material pack_material(const SceneMaterial& material, bool vertex_colors);

}  // namespace lucarium
