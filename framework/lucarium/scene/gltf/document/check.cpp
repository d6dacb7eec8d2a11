// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/gltf/document/check.h"

#include "lucarium/base/json.h"

namespace lucarium::gltf {

namespace {

using Json = nlohmann::json;

const Json& section(const Json& root, const char* name) {
  static const Json empty = Json::array();
  const auto found = root.find(name);
  return found == root.end() ? empty : *found;
}

uint64_t value_or(const Json& object, const char* key, uint64_t fallback) {
  const auto found = object.find(key);
  return found == object.end() ? fallback : found->get<uint64_t>();
}

/// "2.0" → {2, 0}; {-1, -1} where it is not of that form.
std::pair<int, int> parse_version(const std::string& text) {
  const size_t dot = text.find('.');
  const auto digits = [](const std::string& s) {
    return !s.empty() && s.size() < 6 && s.find_first_not_of("0123456789") == std::string::npos;
  };
  if (dot == std::string::npos || !digits(text.substr(0, dot)) || !digits(text.substr(dot + 1))) return {-1, -1};
  return {std::stoi(text.substr(0, dot)), std::stoi(text.substr(dot + 1))};
}

/// Whether `count` elements of `size` bytes, `stride` apart from `offset` on, end within `available` bytes.
bool fits(uint64_t offset, uint64_t count, uint64_t stride, uint64_t size, uint64_t available) {
  if (offset > available || size > available - offset) return false;
  return (count - 1) <= (available - offset - size) / stride;
}

struct ViewRange {
  uint64_t length, stride;
};

ViewRange view_range(const Json& root, const Json& view_index) {
  const Json& view = section(root, "bufferViews")[view_index.get<size_t>()];
  return {value_or(view, "byteLength", 0), value_or(view, "byteStride", 0)};
}

/// Sizes of an element of an accessor. Columns of matrices begin at multiples of four bytes (glTF 2.0,
/// section 3.6.2.4); behind the last column nothing need follow.
struct ElementSize {
  uint64_t padded, bare;
};

ElementSize element_size(int component_type, std::string_view type) {
  const uint64_t padded = element_bytes(component_type, type);
  if (!type.starts_with("MAT")) return {padded, padded};
  const uint64_t rows = static_cast<uint64_t>(type.back() - '0');
  return {padded, padded - padded / rows + rows * component_bytes(component_type)};
}

void check_sparse(const Json& root, const Json& accessor, const ElementSize& element, const std::string& where,
                  const ImportContext& context) {
  const Json& sparse = accessor["sparse"];
  const uint64_t count = sparse["count"].get<uint64_t>();
  if (count > accessor["count"].get<uint64_t>()) {
    context.fail("{}/sparse replaces {} elements of {}", where, count, accessor["count"].get<uint64_t>());
  }
  const Json &indices = sparse["indices"], &values = sparse["values"];
  const uint64_t index_size = component_bytes(indices["componentType"].get<int>());
  if (!fits(value_or(indices, "byteOffset", 0), count, index_size, index_size,
            view_range(root, indices["bufferView"]).length)) {
    context.fail("{}/sparse/indices reaches beyond its buffer view", where);
  }
  if (!fits(value_or(values, "byteOffset", 0), count, element.padded, element.bare,
            view_range(root, values["bufferView"]).length)) {
    context.fail("{}/sparse/values reaches beyond its buffer view", where);
  }
}

void check_accessor(const Json& root, const Json& accessor, const std::string& where, const ImportContext& context) {
  const uint64_t count = accessor["count"].get<uint64_t>();
  const ElementSize element = element_size(accessor["componentType"].get<int>(), accessor["type"].get<std::string>());
  if (accessor.contains("sparse")) check_sparse(root, accessor, element, where, context);
  const auto view_index = accessor.find("bufferView");
  if (view_index == accessor.end()) return;
  const ViewRange view = view_range(root, *view_index);
  if (view.stride && view.stride < element.padded) {
    context.fail("{}: elements of {} bytes do not fit the stride of {} in /bufferViews/{}", where, element.padded,
                 view.stride, view_index->get<uint64_t>());
  }
  const uint64_t offset = value_or(accessor, "byteOffset", 0);
  if (!fits(offset, count, view.stride ? view.stride : element.padded, element.bare, view.length)) {
    context.fail("{}: {} elements of {} bytes from byte {} on reach beyond the {} bytes of /bufferViews/{}", where,
                 count, element.padded, offset, view.length, view_index->get<uint64_t>());
  }
}

/// What tinygltf cannot read, or would read as zeros.
void check_primitive(const Json& root, const Json& primitive, const std::string& where, const ImportContext& context) {
  const Json& accessors = section(root, "accessors");
  const auto has_view = [&](const Json& index) { return accessors[index.get<size_t>()].contains("bufferView"); };
  const Json::json_pointer draco("/extensions/KHR_draco_mesh_compression");
  for (const auto& [key, accessor] : primitive["attributes"].items()) {
    if (has_view(accessor) || !primitive.contains(draco)) continue;
    context.fail(
        "{} has only data compressed with KHR_draco_mesh_compression, which is not supported; export the file "
        "without mesh compression",
        where);
  }
  if (primitive.contains("indices") && !has_view(primitive["indices"])) {
    context.fail("{}/indices: index accessors without a buffer view are not supported", where);
  }
}

std::string node_label(size_t index) { return "/nodes/" + std::to_string(index); }

}  // namespace

uint64_t component_bytes(int component_type) {
  switch (component_type) {
    case 5120:
    case 5121: return 1;
    case 5122:
    case 5123: return 2;
    default: return 4;
  }
}

uint64_t element_bytes(int component_type, std::string_view type) {
  const uint64_t size = component_bytes(component_type);
  if (type == "SCALAR") return size;
  const uint64_t rows = static_cast<uint64_t>(type.back() - '0');
  if (type.starts_with("VEC")) return rows * size;
  return rows * ((rows * size + 3) / 4 * 4);
}

void check_version(const Json& root, const ImportContext& context) {
  if (!root.is_object()) context.fail("the JSON is not an object, so this is not a glTF file");
  const auto asset = root.find("asset");
  const auto text_of = [&](const char* key) -> std::string {
    if (asset == root.end() || !asset->is_object()) return "";
    const auto found = asset->find(key);
    if (found == asset->end()) return "";
    if (!found->is_string()) context.fail("/asset/{} must be a string", key);
    return found->get<std::string>();
  };
  const std::string version = text_of("version"), minimum = text_of("minVersion");
  // glTF 1.0 keeps its elements in objects instead of arrays, and its asset is optional.
  const bool old = version.starts_with("1.") || root.contains("techniques") || root.contains("shaders") ||
                   (root.contains("meshes") && root["meshes"].is_object() && version.empty());
  if (old)
    context.fail("this is glTF {}; only glTF 2.0 can be read, convert it first", version.empty() ? "1.0" : version);
  if (asset == root.end()) context.fail("'asset' is missing, so this is not a glTF 2.0 file");
  if (version.empty()) context.fail("/asset/version is missing");
  if (parse_version(version).first != 2) context.fail("/asset/version is '{}'; only glTF 2.0 can be read", version);
  if (!minimum.empty() && parse_version(minimum) != std::pair(2, 0)) {
    context.fail("it asks for glTF {} or newer (asset.minVersion); 2.0 can be read", minimum);
  }
}

void check_layout(const Json& root, const ImportContext& context) {
  const Json &views = section(root, "bufferViews"), &accessors = section(root, "accessors");
  for (size_t i = 0; i < views.size(); ++i) {
    const uint64_t offset = value_or(views[i], "byteOffset", 0), length = views[i]["byteLength"].get<uint64_t>();
    const uint64_t buffer = views[i]["buffer"].get<uint64_t>();
    const uint64_t available = section(root, "buffers")[buffer]["byteLength"].get<uint64_t>();
    if (!fits(offset, 1, 1, length, available)) {
      context.fail("/bufferViews/{}: {} bytes from byte {} on reach beyond the {} bytes of /buffers/{}", i, length,
                   offset, available, buffer);
    }
    if (value_or(views[i], "byteStride", 4) % 4) context.fail("/bufferViews/{}/byteStride must be a multiple of 4", i);
  }
  for (size_t i = 0; i < accessors.size(); ++i) {
    check_accessor(root, accessors[i], "/accessors/" + std::to_string(i), context);
  }
}

std::vector<int> check_nodes(const Json& root, ImportContext& context) {
  const Json& nodes = section(root, "nodes");
  std::vector<int> parents(nodes.size(), none);
  for (size_t i = 0; i < nodes.size(); ++i) {
    for (const Json& child : section(nodes[i], "children")) {
      int& parent = parents[child.get<size_t>()];
      if (parent != none) {
        context.fail("{} is a child of {} and of {}; a node may have one parent", node_label(child.get<size_t>()),
                     node_label(static_cast<size_t>(parent)), node_label(i));
      }
      parent = static_cast<int>(i);
    }
    const bool has_parts =
        nodes[i].contains("translation") || nodes[i].contains("rotation") || nodes[i].contains("scale");
    if (nodes[i].contains("matrix") && has_parts) {
      context.fail("{} has both a matrix and translation, rotation or scale; only one form is allowed", node_label(i));
    }
  }
  // With one parent each, what cannot be reached from a root is on or below a cycle.
  std::vector<int> pending;
  size_t reached = 0;
  std::vector<bool> seen(nodes.size(), false);
  for (size_t i = 0; i < nodes.size(); ++i) {
    if (parents[i] == none) pending.push_back(static_cast<int>(i));
  }
  while (!pending.empty()) {
    const int node = pending.back();
    pending.pop_back();
    seen[node] = true;
    ++reached;
    for (const Json& child : section(nodes[node], "children")) pending.push_back(child.get<int>());
  }
  if (reached != nodes.size()) {
    const size_t first = static_cast<size_t>(std::find(seen.begin(), seen.end(), false) - seen.begin());
    context.fail("{} is its own ancestor: the nodes form a cycle", node_label(first));
  }
  const Json& scenes = section(root, "scenes");
  for (size_t i = 0; i < scenes.size(); ++i) {
    for (const Json& node : section(scenes[i], "nodes")) {
      if (parents[node.get<size_t>()] == none) continue;
      context.fail("/scenes/{} lists {}, which is a child of {}; only root nodes may be listed", i,
                   node_label(node.get<size_t>()), node_label(static_cast<size_t>(parents[node.get<size_t>()])));
    }
  }
  return parents;
}

void check_details(const Json& root, ImportContext& context) {
  const Json& meshes = section(root, "meshes");
  for (size_t i = 0; i < meshes.size(); ++i) {
    const Json& primitives = meshes[i]["primitives"];
    for (size_t p = 0; p < primitives.size(); ++p) {
      check_primitive(root, primitives[p], fmt::format("/meshes/{}/primitives/{}", i, p), context);
    }
  }
  const Json &animations = section(root, "animations"), &cameras = section(root, "cameras");
  for (size_t i = 0; i < animations.size(); ++i) {
    const Json& channels = animations[i]["channels"];
    const size_t count = animations[i]["samplers"].size();
    for (size_t c = 0; c < channels.size(); ++c) {
      if (channels[c]["sampler"].get<size_t>() < count) continue;
      context.fail("/animations/{}/channels/{}/sampler refers to sampler {}, but there are {}", i, c,
                   channels[c]["sampler"].get<size_t>(), count);
    }
  }
  for (size_t i = 0; i < cameras.size(); ++i) {
    const std::string type = cameras[i]["type"].get<std::string>();
    if (type != "perspective" && type != "orthographic") {
      context.fail("/cameras/{}/type is '{}'; it must be perspective or orthographic", i, type);
    }
    if (!cameras[i].contains(type)) context.fail("/cameras/{}: '{}' is missing", i, type);
  }
  const Json::json_pointer lights_pointer("/extensions/KHR_lights_punctual/lights");
  if (!root.contains(lights_pointer)) return;
  const Json& lights = root[lights_pointer];
  for (size_t i = 0; i < lights.size(); ++i) {
    if (lights[i]["type"] == "spot" && !lights[i].contains("spot")) {
      context.fail("{}/{}: 'spot' is missing", lights_pointer.to_string(), i);
    }
  }
}

}  // namespace lucarium::gltf
