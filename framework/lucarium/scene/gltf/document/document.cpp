// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/gltf/document/document.h"

#include "lucarium/scene/gltf/document/check.h"
#include "lucarium/scene/gltf/document/container.h"
#include "lucarium/scene/gltf/document/schema.h"

namespace lucarium::gltf {

namespace {

std::optional<Bytes> load_buffer(const Json& buffer, size_t index, const std::optional<std::string_view>& binary_chunk,
                                 const Document& document, ImportContext& context) {
  const uint64_t length = buffer["byteLength"].get<uint64_t>();
  const std::string where = "/buffers/" + std::to_string(index);
  Bytes bytes;
  if (buffer.contains("uri")) {
    bytes = read_uri(buffer["uri"].get<std::string>(), document.folder, length, where, context);
    context.count_input_bytes(bytes.size());
  } else if (index == 0 && binary_chunk) {
    bytes.assign(binary_chunk->begin(), binary_chunk->end());
  } else {
    return std::nullopt;
  }
  if (bytes.size() < length) {
    context.fail("{}: its {} are {} bytes long, not {} as stated", where,
                 buffer.contains("uri") ? "data" : "contents in the GLB", bytes.size(), length);
  }
  bytes.resize(length);
  return bytes;
}

void take_images(const Json& root, Document& document, const ImportContext& context) {
  const auto images = root.find("images");
  if (images == root.end()) return;
  for (size_t i = 0; i < images->size(); ++i) {
    const Json& image = (*images)[i];
    ImageSource source;
    source.name = image.value("name", "");
    source.uri = image.value("uri", "");
    source.buffer_view = image.value("bufferView", none);
    if (image.contains("uri") && source.buffer_view != none) {
      context.fail("/images/{} has both a uri and a bufferView; only one is allowed", i);
    }
    document.images.push_back(std::move(source));
  }
}

/// Takes out what tinygltf need not see: files, and free-form data that it would copy. It refuses some accessors that
/// glTF allows (indices without a buffer view), so its complaints are passed on.
void parse_with_tinygltf(Json& root, Document& document, ImportContext& context) {
  root.erase("buffers");
  root.erase("images");
  root.erase("extras");
  if (root.contains("animations")) {
    for (Json& animation : root["animations"]) animation.erase("extensions");  // copied once per sampler
  }
  const std::string text = root.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string errors, warnings;
  tinygltf::TinyGLTF loader;
  if (text.size() > UINT32_MAX) context.fail("its JSON is larger than 4 GiB");
  if (!loader.LoadASCIIFromString(&document.model, &errors, &warnings, text.c_str(),
                                  static_cast<unsigned int>(text.size()), "", tinygltf::NO_REQUIRE)) {
    context.fail("{}", errors.empty() ? "tinygltf cannot read it" : errors);
  }
}

}  // namespace

Document read_document(std::string_view bytes, const std::filesystem::path& folder, ImportContext& context) {
  const Container container = split_container(bytes, context);
  Json root = parse_json(container.json, context);
  check_version(root, context);
  Document document;
  document.folder = folder;
  document.extensions = check_extensions(root, context);
  check_json(root, gltf_rules(), context);
  check_details(root, context);
  check_layout(root, context);
  document.parents = check_nodes(root, context);
  if (root.contains("buffers")) {
    const Json& buffers = root["buffers"];
    for (size_t i = 0; i < buffers.size(); ++i) {
      document.buffers.push_back(load_buffer(buffers[i], i, container.binary_chunk, document, context));
    }
  }
  take_images(root, document, context);
  parse_with_tinygltf(root, document, context);
  return document;
}

std::string_view view_bytes(const Document& document, int buffer_view, const std::string& where,
                            const ImportContext& context) {
  const tinygltf::BufferView& view = document.model.bufferViews[buffer_view];
  const std::optional<Bytes>& buffer = document.buffers[view.buffer];
  if (!buffer) context.fail("{}: /buffers/{} has no contents, neither by uri nor in a GLB", where, view.buffer);
  return {reinterpret_cast<const char*>(buffer->data()) + view.byteOffset, view.byteLength};
}

const tinygltf::Value* extension(const tinygltf::ExtensionMap& extensions, const char* name) {
  const auto found = extensions.find(name);
  return found == extensions.end() ? nullptr : &found->second;
}

double number_or(const tinygltf::Value& object, const char* key, double fallback) {
  return object.Has(key) ? object.Get(key).GetNumberAsDouble() : fallback;
}

int index_or_none(const tinygltf::Value& object, const char* key) {
  return object.Has(key) ? object.Get(key).GetNumberAsInt() : none;
}

}  // namespace lucarium::gltf
