// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/gltf/model/mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "lucarium/scene/device/texture_sampling.h"
#include "lucarium/scene/mesh_attributes.h"

namespace lucarium::gltf {

namespace {

/// Triangles of a list, strip or fan (glTF 2.0, section 3.7.2.1).
std::vector<glm::uvec3> assemble_triangles(int mode, const std::vector<uint32_t>& v) {
  std::vector<glm::uvec3> triangles;
  if (v.size() < 3) return triangles;
  if (mode == TINYGLTF_MODE_TRIANGLES) {
    triangles.reserve(v.size() / 3);
    for (size_t i = 0; i + 2 < v.size(); i += 3) triangles.emplace_back(v[i], v[i + 1], v[i + 2]);
    return triangles;
  }
  triangles.reserve(v.size() - 2);
  for (size_t i = 0; i + 2 < v.size(); ++i) {
    if (mode == TINYGLTF_MODE_TRIANGLE_FAN) {
      triangles.emplace_back(v[i + 1], v[i + 2], v[0]);
    } else {
      triangles.emplace_back(v[i], v[i + 1 + i % 2], v[i + 2 - i % 2]);
    }
  }
  return triangles;
}

}  // namespace

const std::vector<int>& MeshImporter::import_mesh(int index) {
  const auto [entry, fresh] = imported_.try_emplace(index);
  if (!fresh) return entry->second;
  const tinygltf::Mesh& source = document_.model.meshes[index];
  for (size_t p = 0; p < source.primitives.size(); ++p) {
    std::string name = source.name.empty() ? fmt::format("mesh {}", index) : source.name;
    if (source.primitives.size() > 1) name += fmt::format(":{}", p);
    std::optional<Mesh> mesh = import_primitive(source.primitives[p], name);
    if (!mesh) continue;
    entry->second.push_back(static_cast<int>(scene_.meshes.size()));
    scene_.meshes.push_back(std::move(*mesh));
  }
  return entry->second;
}

int MeshImporter::attribute(const std::map<std::string, int>& attributes, const std::string& key,
                            const std::string& where, const Mesh& mesh) const {
  const auto found = attributes.find(key);
  if (found == attributes.end()) return none;
  const size_t count = reader_.count(found->second);
  if (!mesh.positions.empty() && count != mesh.positions.size()) {
    context_.fail("{}: {} has {} elements, but there are {} positions", where, key, count, mesh.positions.size());
  }
  return found->second;
}

std::optional<Mesh> MeshImporter::import_primitive(const tinygltf::Primitive& primitive, const std::string& name) {
  const std::string where = fmt::format("mesh '{}'", name);
  if (primitive.mode < TINYGLTF_MODE_TRIANGLES) {
    context_.warn("points and lines are not rendered: primitives with them were left out");
    return std::nullopt;
  }
  Mesh mesh;
  mesh.name = name;
  const int positions = attribute(primitive.attributes, "POSITION", where, mesh);
  if (positions == none) {
    context_.warn("{} has no positions and was left out", where);
    return std::nullopt;
  }
  mesh.positions = reader_.vec3(positions, where + ": POSITION");
  mesh.triangles = read_triangles(primitive, mesh.positions.size(), where);
  if (mesh.triangles.empty()) {
    context_.warn("{} has no triangle and was left out", where);
    return std::nullopt;
  }
  mesh.material = primitive.material == none ? default_material() : primitive.material;
  read_surface_attributes(primitive, where, mesh);
  read_skin_attributes(primitive, where, mesh);
  read_morph_targets(primitive, where, mesh);
  finish_normals_and_tangents(where, mesh);
  return mesh;
}

std::vector<glm::uvec3> MeshImporter::read_triangles(const tinygltf::Primitive& primitive, size_t vertices,
                                                     const std::string& where) {
  std::vector<uint32_t> indices;
  if (primitive.indices == none) {
    if (vertices > UINT32_MAX) context_.fail("{}: more than 2^32 vertices are not supported", where);
    context_.spend_bytes(vertices * sizeof(uint32_t));
    indices.resize(vertices);
    std::iota(indices.begin(), indices.end(), 0u);
  } else {
    indices = reader_.integers(primitive.indices, 1, where + ": indices");
  }
  for (size_t i = 0; i < indices.size(); ++i) {
    if (indices[i] < vertices) continue;
    context_.fail("{}: index {} at position {} lies outside its {} vertices", where, indices[i], i, vertices);
  }
  if (primitive.mode == TINYGLTF_MODE_TRIANGLES && indices.size() % 3) {
    context_.warn("{}: {} vertices make no whole number of triangles; the rest was left out", where, indices.size());
  }
  context_.spend_bytes(indices.size() * (primitive.mode == TINYGLTF_MODE_TRIANGLES ? 4 : sizeof(glm::uvec3)));
  return assemble_triangles(primitive.mode, indices);
}

void MeshImporter::read_surface_attributes(const tinygltf::Primitive& primitive, const std::string& where, Mesh& mesh) {
  const auto find = [&](const char* key) { return attribute(primitive.attributes, key, where, mesh); };
  if (const int normal = find("NORMAL"); normal != none) mesh.normals = reader_.vec3(normal, where + ": NORMAL");
  if (const int tangent = find("TANGENT"); tangent != none) {
    if (mesh.normals.empty())
      context_.warn("{} has tangents without normals; they were ignored", where);
    else
      mesh.tangents = reader_.vec4(tangent, where + ": TANGENT");
  }
  const char* sets[] = {"TEXCOORD_0", "TEXCOORD_1"};
  for (int set = 0; set < 2; ++set) {
    if (const int uv = find(sets[set]); uv != none) mesh.uv[set] = reader_.vec2(uv, where + ": " + sets[set]);
  }
  if (const int color = find("COLOR_0"); color != none) {
    if (reader_.width(color) == 3) {
      for (const glm::vec3& c : reader_.vec3(color, where + ": COLOR_0")) mesh.colors.emplace_back(c, 1.f);
    } else {
      mesh.colors = reader_.vec4(color, where + ": COLOR_0");
    }
    for (glm::vec4& c : mesh.colors) c = glm::clamp(c, 0.f, 1.f);
  }
  for (const auto& [key, accessor] : primitive.attributes) {
    if (key.starts_with("COLOR_") && key != "COLOR_0")
      context_.warn("only COLOR_0 is used: further vertex colours were ignored");
  }
}

void MeshImporter::read_skin_attributes(const tinygltf::Primitive& primitive, const std::string& where, Mesh& mesh) {
  struct Influence {
    float weight;
    uint16_t joint;
  };
  std::vector<std::vector<uint32_t>> joints;
  std::vector<std::vector<float>> weights;
  for (int set = 0;; ++set) {
    const std::string joints_key = fmt::format("JOINTS_{}", set), weights_key = fmt::format("WEIGHTS_{}", set);
    const int joint = attribute(primitive.attributes, joints_key, where, mesh);
    const int weight = attribute(primitive.attributes, weights_key, where, mesh);
    if ((joint == none) != (weight == none))
      context_.fail("{}: {} and {} must come together", where, joints_key, weights_key);
    if (joint == none) break;
    joints.push_back(reader_.integers(joint, 4, where + ": " + joints_key));
    weights.push_back(reader_.floats(weight, 4, where + ": " + weights_key));
  }
  if (joints.empty()) return;
  if (joints.size() > 1) context_.warn("{} has more than 4 joints per vertex: the strongest 4 are used", where);
  bool off = false;
  std::vector<Influence> influences;
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    influences.clear();
    float given = 0;
    for (size_t set = 0; set < joints.size(); ++set) {
      for (size_t i = 4 * v; i < 4 * v + 4; ++i) {
        if (weights[set][i] < 0) off = true;
        if (weights[set][i] <= 0) continue;
        if (joints[set][i] > UINT16_MAX) context_.fail("{}: joint {} is too large", where, joints[set][i]);
        influences.push_back({weights[set][i], static_cast<uint16_t>(joints[set][i])});
        given += weights[set][i];
      }
    }
    std::stable_sort(influences.begin(), influences.end(), [](auto& a, auto& b) { return a.weight > b.weight; });
    influences.resize(4, {0.f, 0});
    const float sum = influences[0].weight + influences[1].weight + influences[2].weight + influences[3].weight;
    if (!(std::abs(given - 1.f) < 0.02f)) off = true;
    std::array<uint16_t, 4> vertex_joints{};
    glm::vec4 vertex_weights(0.f);
    for (int i = 0; i < 4; ++i) {
      vertex_joints[i] = influences[i].joint;
      vertex_weights[i] = sum > 0 ? influences[i].weight / sum : 0.f;
    }
    mesh.joints.push_back(vertex_joints);
    mesh.weights.push_back(vertex_weights);
  }
  if (off) context_.warn("{} has joint weights that are negative or do not add up to 1; they were normalized", where);
}

void MeshImporter::read_morph_targets(const tinygltf::Primitive& primitive, const std::string& where, Mesh& mesh) {
  for (size_t t = 0; t < primitive.targets.size(); ++t) {
    const std::string label = fmt::format("{}: morph target {}", where, t);
    const auto deltas = [&](const char* key, bool has_base) -> std::vector<glm::vec3> {
      const int accessor = attribute(primitive.targets[t], key, label, mesh);
      if (accessor == none) return {};
      if (!has_base) {
        context_.warn("{} moves {}, which the mesh does not have; it was ignored", label, key);
        return {};
      }
      return reader_.vec3(accessor, label + ": " + key);
    };
    MorphTarget target;
    target.positions = deltas("POSITION", true);
    target.normals = deltas("NORMAL", !mesh.normals.empty());
    target.tangents = deltas("TANGENT", !mesh.tangents.empty());
    for (const auto& [key, accessor] : primitive.targets[t]) {
      if (key == "POSITION" || key == "NORMAL" || key == "TANGENT") continue;
      context_.warn("{}: morphing of {} is not supported and was ignored", where, key);
    }
    mesh.morph_targets.push_back(std::move(target));
  }
}

void MeshImporter::finish_normals_and_tangents(const std::string& where, Mesh& mesh) {
  if (mesh.normals.empty()) {
    context_.spend_bytes(mesh.triangles.size() * 3 * 48 * (1 + mesh.morph_targets.size()));
    make_flat_normals(mesh);
  } else if (const size_t repaired = repair_normals(mesh)) {
    context_.warn("{} has {} normals of length 0; they were made from its triangles", where, repaired);
  }
  const SceneMaterial& material = scene_.materials[mesh.material];
  const TextureUse& normal_map = material.normal_texture;
  if (!mesh.tangents.empty()) {
    repair_tangents(mesh);
  } else if (normal_map.texture != none && !mesh.uv[normal_map.uv_set].empty()) {
    const TextureTransform transform = texture_transform(normal_map);
    std::vector<glm::vec2> uv = mesh.uv[normal_map.uv_set];
    for (glm::vec2& coordinates : uv) coordinates = transform(coordinates);
    make_tangents(mesh, uv);
  }
  for (const TextureUse* use : {&material.base_color_texture, &material.metallic_roughness_texture, &normal_map,
                                &material.emissive_texture, &material.transmission_texture}) {
    if (use->texture == none || !mesh.uv[use->uv_set].empty()) continue;
    context_.warn("{} lacks TEXCOORD_{}, which its material '{}' uses: (0, 0) is taken everywhere", where, use->uv_set,
                  material.name);
  }
}

int MeshImporter::default_material() {
  if (default_material_ != none) return default_material_;
  default_material_ = static_cast<int>(scene_.materials.size());
  SceneMaterial material;
  material.name = "default";
  scene_.materials.push_back(material);
  context_.warn(
      "some primitives have no material: glTF's default is used (white, so light barely fades); --material default:... "
      "changes it");
  return default_material_;
}

}  // namespace lucarium::gltf
