// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/gltf/import.h"

#include <new>

#include "lucarium/scene/gltf/model/animation.h"
#include "lucarium/scene/gltf/model/material.h"
#include "lucarium/scene/gltf/model/nodes.h"
#include "lucarium/scene/import_options.h"

namespace lucarium {

namespace {

constexpr size_t longest_message = 600;

/// One line, whatever names the file contains.
std::string single_line(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  }
  while (!text.empty() && text.back() == ' ') text.pop_back();
  if (text.size() > longest_message) text = text.substr(0, longest_message) + "...";
  return text;
}

Scene import_checked(std::string_view bytes, const std::filesystem::path& folder, gltf::ImportContext& context) {
  context.count_input_bytes(bytes.size());
  const gltf::Document document = gltf::read_document(bytes, folder, context);
  Scene scene;
  scene.source = context.name();
  scene.extensions_used = document.extensions.used;
  scene.extensions_ignored = document.extensions.ignored;
  gltf::import_nodes(document, scene, context);
  gltf::import_materials(document, gltf::used_materials(document, scene), scene, context);
  gltf::import_instances(document, scene, context);
  gltf::import_lights(document, scene, context);
  gltf::import_cameras(document, scene, context);
  gltf::import_animations(document, scene, context);
  if (scene.materials.empty()) {
    scene.materials.emplace_back();
    scene.materials.back().name = "default";
  }
  for (const std::string& warning : context.warnings()) scene.warnings.push_back(single_line(warning));
  return scene;
}

}  // namespace

Scene import_gltf_bytes(std::string_view bytes, const std::filesystem::path& folder, const std::string& shown_name,
                        const ImportOptions& options) {
  gltf::ImportContext context(shown_name, options);
  try {
    return import_checked(bytes, folder, context);
  } catch (const Error& error) {
    throw Error(error.error_class(), single_line(error.what())).with_details(error.details());
  } catch (const std::bad_alloc&) {
    throw_error(ErrorClass::input, "{}: reading it needs more memory than there is", shown_name);
  }
}

Scene import_gltf(const std::filesystem::path& file, const ImportOptions& options) {
  const gltf::ImportContext context(file.string(), options);
  const gltf::Bytes bytes = gltf::read_file(file, UINT64_MAX, "", context);
  return import_gltf_bytes({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, file.parent_path(),
                           file.string(), options);
}

}  // namespace lucarium
