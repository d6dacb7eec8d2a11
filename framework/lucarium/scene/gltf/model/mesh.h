// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>

#include "lucarium/scene/gltf/model/accessor.h"

namespace lucarium::gltf {

/// Turns glTF primitives into meshes of the scene, each once, however many nodes show it.
class MeshImporter {
 public:
  /// The scene's materials must be there already (normal maps decide about tangents); primitives without one refer to
  /// the default material, which is appended.
  MeshImporter(const Document& document, Scene& scene, ImportContext& context)
      : document_(document), scene_(scene), context_(context), reader_(document, context) {}

  /// Indices into scene.meshes of the primitives that have triangles.
  const std::vector<int>& import_mesh(int gltf_mesh);

 private:
  std::optional<Mesh> import_primitive(const tinygltf::Primitive& primitive, const std::string& name);
  std::vector<glm::uvec3> read_triangles(const tinygltf::Primitive& primitive, size_t vertices,
                                         const std::string& where);
  void read_surface_attributes(const tinygltf::Primitive& primitive, const std::string& where, Mesh& mesh);
  void read_skin_attributes(const tinygltf::Primitive& primitive, const std::string& where, Mesh& mesh);
  void read_morph_targets(const tinygltf::Primitive& primitive, const std::string& where, Mesh& mesh);
  void finish_normals_and_tangents(const std::string& where, Mesh& mesh);
  /// Accessor of an attribute, or none; refuses a count that differs from the positions'.
  int attribute(const std::map<std::string, int>& attributes, const std::string& key, const std::string& where,
                const Mesh& mesh) const;
  int default_material();

  const Document& document_;
  Scene& scene_;
  ImportContext& context_;
  AccessorReader reader_;
  std::map<int, std::vector<int>> imported_;
  int default_material_ = none;
};

}  // namespace lucarium::gltf
