// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "lucarium/base/json.h"
#include "lucarium/scene/gltf/import.h"
#include "lucarium/scene/import_options.h"

namespace lucarium::test {

/// Writes small glTF documents: one buffer that grows, and JSON that tests may edit at will.
class GltfBuilder {
 public:
  nlohmann::json json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", {{{"nodes", {0}}}}}};

  /// Appends bytes as a buffer view; returns its index.
  int add_view(const void* data, size_t bytes, int stride = 0) {
    buffer_.resize((buffer_.size() + 3) / 4 * 4);
    nlohmann::json view = {{"buffer", 0}, {"byteOffset", buffer_.size()}, {"byteLength", bytes}};
    if (stride) view["byteStride"] = stride;
    buffer_.append(static_cast<const char*>(data), bytes);
    return append("bufferViews", view);
  }

  int add_accessor(int view, int component_type, size_t count, const char* type, bool normalized = false) {
    nlohmann::json accessor = {{"componentType", component_type}, {"count", count}, {"type", type}};
    if (view >= 0) accessor["bufferView"] = view;
    if (normalized) accessor["normalized"] = true;
    return append("accessors", accessor);
  }

  /// Elements of integers or floats, tightly packed.
  template <class T>
  int add(const std::vector<T>& values, const char* type, bool normalized = false) {
    const std::string name = type;
    const size_t width = name == "SCALAR" ? 1 : name == "MAT4" ? 16 : static_cast<size_t>(name.back() - '0');
    const int view = add_view(values.data(), values.size() * sizeof(T));
    return add_accessor(view, component<T>(), values.size() / width, type, normalized);
  }

  int add_floats(const std::vector<std::vector<float>>& elements, const char* type) {
    std::vector<float> values;
    for (const auto& element : elements) values.insert(values.end(), element.begin(), element.end());
    return add(values, type);
  }

  /// A mesh of one primitive on node 0; returns the primitive for more attributes.
  nlohmann::json& add_mesh(int positions) {
    append("meshes", {{"primitives", {{{"attributes", {{"POSITION", positions}}}}}}});
    append("nodes", {{"mesh", json["meshes"].size() - 1}});
    return json["meshes"].back()["primitives"][0];
  }

  int append(const char* section, const nlohmann::json& element) {
    json[section].push_back(element);
    return static_cast<int>(json[section].size()) - 1;
  }

  /// (0,0,0) (1,0,0) (0,1,0).
  static GltfBuilder triangle() {
    GltfBuilder builder;
    builder.add_mesh(builder.add_floats({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, "VEC3"));
    return builder;
  }

  /// That triangle with texture coordinates (0,0) (1,0) (0,-1) and a base colour texture from encoded bytes.
  static GltfBuilder textured_triangle(const std::string& image, const char* mime_type) {
    GltfBuilder builder = triangle();
    const int uv = builder.add_floats({{0, 0}, {1, 0}, {0, -1}}, "VEC2");
    auto& primitive = builder.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["TEXCOORD_0"] = uv;
    primitive["material"] = 0;
    const int view = builder.add_view(image.data(), image.size());
    builder.append("images", {{"bufferView", view}, {"mimeType", mime_type}});
    builder.append("textures", {{"source", 0}});
    builder.append("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
    return builder;
  }

  /// The document with its buffer as a data URI.
  std::string text() const {
    nlohmann::json document = json;
    if (!buffer_.empty()) {
      document["buffers"] = {
          {{"byteLength", buffer_.size()}, {"uri", "data:application/octet-stream;base64," + base64(buffer_)}}};
    }
    return document.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  }

  std::string glb() const {
    nlohmann::json document = json;
    document["buffers"] = {{{"byteLength", buffer_.size()}}};
    std::string text = document.dump(), binary = buffer_;
    text.resize((text.size() + 3) / 4 * 4, ' ');
    binary.resize((binary.size() + 3) / 4 * 4, '\0');
    return "glTF" + u32(2) + u32(12 + 8 + text.size() + 8 + binary.size()) + u32(text.size()) + "JSON" + text +
           u32(binary.size()) + std::string("BIN\0", 4) + binary;
  }

  static std::string base64(const std::string& bytes) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (size_t i = 0; i < bytes.size(); i += 3) {
      uint32_t bits = 0;
      for (size_t k = 0; k < 3; ++k)
        bits = bits << 8 | (i + k < bytes.size() ? static_cast<uint8_t>(bytes[i + k]) : 0u);
      const size_t present = std::min<size_t>(bytes.size() - i, 3);
      for (size_t k = 0; k < 4; ++k) out += k <= present ? digits[bits >> (18 - 6 * k) & 63] : '=';
    }
    return out;
  }

 private:
  template <class T>
  static int component() {
    if constexpr (std::is_same_v<T, int8_t>) return 5120;
    if constexpr (std::is_same_v<T, uint8_t>) return 5121;
    if constexpr (std::is_same_v<T, int16_t>) return 5122;
    if constexpr (std::is_same_v<T, uint16_t>) return 5123;
    if constexpr (std::is_same_v<T, uint32_t>) return 5125;
    return 5126;
  }
  static std::string u32(size_t value) {
    std::string bytes(4, '\0');
    for (int i = 0; i < 4; ++i) bytes[static_cast<size_t>(i)] = static_cast<char>(value >> (8 * i) & 255);
    return bytes;
  }

  std::string buffer_;
};

inline Scene load(const GltfBuilder& builder, const ImportOptions& options = {}) {
  return import_gltf_bytes(builder.text(), ".", "test.gltf", options);
}

/// Whether a warning holds this text.
inline bool warns(const Scene& scene, const std::string& part) {
  return std::any_of(scene.warnings.begin(), scene.warnings.end(),
                     [&](const std::string& text) { return text.find(part) != std::string::npos; });
}

}  // namespace lucarium::test
