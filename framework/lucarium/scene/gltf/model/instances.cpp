// SPDX-License-Identifier: Apache-2.0
// Occurrences of meshes: visible nodes, EXT_mesh_gpu_instancing, skins. Declared in nodes.h.
#include <algorithm>
#include <cmath>

#include "lucarium/scene/gltf/model/nodes.h"

namespace lucarium::gltf {

namespace {

class InstanceImporter {
 public:
  InstanceImporter(const Document& document, Scene& scene, ImportContext& context)
      : document_(document),
        scene_(scene),
        context_(context),
        meshes_(document, scene, context),
        reader_(document, context) {}

  void import_all() {
    for (size_t i = 0; i < document_.model.skins.size(); ++i) import_skin(i);
    for (size_t i = 0; i < document_.model.nodes.size(); ++i) {
      const tinygltf::Node& source = document_.model.nodes[i];
      if (source.mesh == none) {
        if (source.skin != none) context_.warn("{}: it has a skin but no mesh", label("node", i, source.name));
        continue;
      }
      if (scene_.nodes[i].in_scene) import_mesh_node(i, source);
    }
  }

 private:
  void import_skin(size_t index) {
    const tinygltf::Skin& source = document_.model.skins[index];
    const std::string where = label("skin", index, source.name);
    Skin skin;
    skin.name = source.name;
    skin.joints = source.joints;
    if (source.inverseBindMatrices != none) {
      skin.inverse_bind = reader_.mat4(source.inverseBindMatrices, where + ": inverseBindMatrices");
      if (skin.inverse_bind.size() < skin.joints.size()) {
        context_.fail("{}: {} inverse bind matrices do not suffice for {} joints", where, skin.inverse_bind.size(),
                      skin.joints.size());
      }
      skin.inverse_bind.resize(skin.joints.size());
      for (glm::mat4& m : skin.inverse_bind) {
        if (m[0][3] == 0 && m[1][3] == 0 && m[2][3] == 0 && m[3][3] == 1) continue;
        context_.warn("{}: inverse bind matrices are not affine; the last row was taken as 0 0 0 1", where);
        for (int c = 0; c < 4; ++c) m[c][3] = c == 3;
      }
    }
    scene_.skins.push_back(std::move(skin));
  }

  void import_mesh_node(size_t index, const tinygltf::Node& source) {
    const std::vector<int>& meshes = meshes_.import_mesh(source.mesh);
    if (meshes.empty()) return;
    Node& node = scene_.nodes[index];
    node.meshes = meshes;
    set_morph_weights(index, source, node);
    attach_skin(index, source, node);
    if (const auto* instancing = extension(source.extensions, "EXT_mesh_gpu_instancing")) {
      import_gpu_instances(static_cast<int>(index), *instancing);
    } else {
      for (const int mesh : meshes) add_instance(static_cast<int>(index), mesh);
    }
  }

  void set_morph_weights(size_t index, const tinygltf::Node& source, Node& node) {
    size_t targets = 0;
    for (const int mesh : node.meshes) targets = std::max(targets, scene_.meshes[mesh].morph_targets.size());
    const std::vector<double>& weights =
        source.weights.empty() ? document_.model.meshes[source.mesh].weights : source.weights;
    if (!weights.empty() && weights.size() != targets) {
      context_.warn("{}: {} morph weights for {} targets", label("node", index, source.name), weights.size(), targets);
    }
    node.morph_weights.assign(weights.begin(), weights.end());
    node.morph_weights.resize(targets, 0.f);
  }

  void attach_skin(size_t index, const tinygltf::Node& source, Node& node) {
    const std::string where = label("node", index, source.name);
    for (const int m : node.meshes) {
      const Mesh& mesh = scene_.meshes[m];
      if (source.skin == none) {
        if (!mesh.joints.empty()) context_.warn("{}: mesh '{}' has joints but the node has no skin", where, mesh.name);
        continue;
      }
      if (mesh.joints.empty())
        context_.warn("{}: mesh '{}' has no joints and is not moved by the skin", where, mesh.name);
      const size_t joints = scene_.skins[source.skin].joints.size();
      for (const auto& vertex : mesh.joints) {
        const uint16_t largest = *std::max_element(vertex.begin(), vertex.end());
        if (largest < joints) continue;
        context_.fail("{}: mesh '{}' refers to joint {}, but its skin has {}", where, mesh.name, largest, joints);
      }
    }
    node.skin = source.skin;
  }

  /// One child node per instance, so that animated parents carry them along.
  void import_gpu_instances(int parent, const tinygltf::Value& instancing) {
    const std::string where =
        label("node", static_cast<size_t>(parent), scene_.nodes[parent].name) + ": EXT_mesh_gpu_instancing";
    const tinygltf::Value& attributes = instancing.Get("attributes");
    const auto accessor = [&](const char* key) { return index_or_none(attributes, key); };
    const int translations = accessor("TRANSLATION"), rotations = accessor("ROTATION"), scales = accessor("SCALE");
    size_t count = 0;
    for (const std::string& key : attributes.Keys()) {
      const size_t elements = reader_.count(accessor(key.c_str()));
      if (count && elements != count) context_.fail("{}: its attributes have different lengths", where);
      count = elements;
    }
    std::vector<glm::vec3> translation, scale;
    std::vector<glm::vec4> rotation;
    if (translations != none) translation = reader_.vec3(translations, where + ", TRANSLATION");
    if (rotations != none) rotation = reader_.vec4(rotations, where + ", ROTATION");
    if (scales != none) scale = reader_.vec3(scales, where + ", SCALE");
    if (scene_.nodes[parent].skin != none) context_.fail("{}: instances of skinned meshes are not supported", where);
    context_.spend_bytes(count * (sizeof(Node) + sizeof(SceneInstance)));
    for (size_t i = 0; i < count; ++i) {
      const int index = static_cast<int>(scene_.nodes.size());
      Node node;
      node.name = fmt::format("{}:{}", scene_.nodes[parent].name, i);
      node.parent = parent;
      node.meshes = scene_.nodes[parent].meshes;
      node.morph_weights = scene_.nodes[parent].morph_weights;
      if (!translation.empty()) node.translation = translation[i];
      if (!scale.empty()) node.scale = scale[i];
      if (!rotation.empty() && glm::length(rotation[i]) > 1e-6f) {
        const glm::vec4 r = glm::normalize(rotation[i]);
        node.rotation = glm::quat(r.w, r.x, r.y, r.z);
      }
      scene_.nodes[parent].children.push_back(index);
      scene_.nodes.push_back(std::move(node));
      for (const int mesh : scene_.nodes[index].meshes) add_instance(index, mesh);
    }
    scene_.nodes[parent].meshes.clear();
  }

  void add_instance(int node, int mesh) {
    triangles_ += scene_.meshes[mesh].triangles.size();
    if (triangles_ > context_.options.max_triangles) {
      context_.fail("it has more than {} triangles, counting every instance", context_.options.max_triangles);
    }
    SceneInstance instance;
    instance.node = node;
    instance.mesh = mesh;
    instance.material = scene_.meshes[mesh].material;
    scene_.instances.push_back(std::move(instance));
  }

  const Document& document_;
  Scene& scene_;
  ImportContext& context_;
  MeshImporter meshes_;
  AccessorReader reader_;
  uint64_t triangles_ = 0;
};

}  // namespace

void import_instances(const Document& document, Scene& scene, ImportContext& context) {
  InstanceImporter(document, scene, context).import_all();
}

}  // namespace lucarium::gltf
