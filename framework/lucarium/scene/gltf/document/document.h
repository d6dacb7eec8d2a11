// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tiny_gltf.h>

#include <filesystem>
#include <optional>
#include <string_view>

#include "lucarium/scene/gltf/document/extensions.h"
#include "lucarium/scene/gltf/document/uri.h"

namespace lucarium::gltf {

/// Where an image's encoded bytes are.
struct ImageSource {
  std::string name, uri;
  int buffer_view = none;
};

/// A checked glTF document. Every index in `model` is valid, every buffer view lies inside its buffer and every
/// accessor inside its views; the node graph is a forest. Buffers and images are kept here instead of in the model,
/// so that tinygltf reads no files.
struct Document {
  tinygltf::Model model;
  std::vector<std::optional<Bytes>> buffers;  ///< empty: placeholder without contents (meshopt fallback)
  std::vector<ImageSource> images;
  std::vector<int> parents;  ///< of each node
  ExtensionLists extensions;
  std::filesystem::path folder;  ///< relative URIs start here
};

/// Splits, parses and checks a file, loads its buffers, and parses it with tinygltf.
Document read_document(std::string_view bytes, const std::filesystem::path& folder, ImportContext& context);

/// The bytes of a buffer view; fails where its buffer has no contents. `where` names the user in messages.
std::string_view view_bytes(const Document& document, int buffer_view, const std::string& where,
                            const ImportContext& context);

/// The extension's object; null where it is absent.
const tinygltf::Value* extension(const tinygltf::ExtensionMap& extensions, const char* name);
double number_or(const tinygltf::Value& object, const char* key, double fallback);
int index_or_none(const tinygltf::Value& object, const char* key);

}  // namespace lucarium::gltf
