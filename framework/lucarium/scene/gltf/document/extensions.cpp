// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/gltf/document/extensions.h"

#include <algorithm>
#include <set>

#include "lucarium/base/json.h"

namespace lucarium::gltf {

namespace {

using Json = nlohmann::json;

enum class Support {
  full,      ///< has its effect
  default_,  ///< the file's default look is used (variants)
  harmless,  ///< ignored without loss of light transport: metadata
  look,      ///< ignored with a warning, although the look changes; also where required
  texture,   ///< textures fall back to their plain image; decided per texture
  needed     ///< the geometry cannot be read without it
};

struct Known {
  const char* name;
  Support support;
  const char* note;  ///< what ignoring means, or the remedy
};

constexpr const char* compression_remedy = "export the file without mesh compression";
constexpr Known known[] = {
    {"KHR_lights_punctual", Support::full, ""},
    {"KHR_materials_emissive_strength", Support::full, ""},
    {"KHR_texture_transform", Support::full, ""},
    {"KHR_materials_ior", Support::full, ""},
    {"KHR_materials_transmission", Support::full, ""},
    {"KHR_materials_volume", Support::full, ""},
    {"KHR_materials_unlit", Support::full, ""},
    {"KHR_materials_pbrSpecularGlossiness", Support::full, ""},
    {"KHR_mesh_quantization", Support::full, ""},
    {"EXT_mesh_gpu_instancing", Support::full, ""},
    {"KHR_materials_variants", Support::default_, "the default materials are used"},
    {"KHR_xmp", Support::harmless, ""},
    {"KHR_xmp_json_ld", Support::harmless, ""},
    {"KHR_materials_clearcoat", Support::look, "coats are left out"},
    {"KHR_materials_sheen", Support::look, "sheen is left out"},
    {"KHR_materials_anisotropy", Support::look, "highlights are isotropic"},
    {"KHR_materials_iridescence", Support::look, "thin-film colours are left out"},
    {"KHR_materials_specular", Support::look, "dielectrics keep the specular strength of their index of refraction"},
    {"KHR_materials_dispersion", Support::look, "refraction is the same for all colours"},
    {"KHR_materials_diffuse_transmission", Support::look, "surfaces do not transmit diffusely"},
    {"EXT_texture_webp", Support::texture, "export the textures as PNG or JPEG"},
    {"KHR_texture_basisu", Support::texture, "export the textures as PNG or JPEG"},
    {"KHR_draco_mesh_compression", Support::needed, compression_remedy},
    {"EXT_meshopt_compression", Support::needed, compression_remedy},
    {"KHR_meshopt_compression", Support::needed, compression_remedy},
};

const Known* find_known(const std::string& name) {
  for (const Known& extension : known) {
    if (name == extension.name) return &extension;
  }
  return nullptr;
}

std::set<std::string> texts(const Json& root, const char* key) {
  std::set<std::string> result;
  const auto found = root.find(key);
  if (found == root.end() || !found->is_array()) return result;
  for (const Json& text : *found) {
    if (text.is_string()) result.insert(text.get<std::string>());
  }
  return result;
}

/// Keys of every "extensions" object; the nesting is limited, so recursion is safe.
void collect(const Json& value, std::set<std::string>& names) {
  if (value.is_array()) {
    for (const Json& element : value) {
      if (element.is_structured()) collect(element, names);
    }
  }
  if (!value.is_object()) return;
  for (const auto& [key, member] : value.items()) {
    if (key == "extras" || !member.is_structured()) continue;
    if (key == "extensions" && member.is_object()) {
      for (const auto& [name, content] : member.items()) names.insert(name);
    }
    collect(member, names);
  }
}

}  // namespace

ExtensionLists check_extensions(const Json& root, ImportContext& context) {
  std::set<std::string> names = texts(root, "extensionsRequired");
  for (const std::string& name : names) {
    const Known* extension = find_known(name);
    if (!extension)
      context.fail("it requires the extension {}, which is not supported; export the file without it", name);
    if (extension->support == Support::needed) {
      context.fail("it requires the extension {}, which is not supported; {}", name, extension->note);
    }
  }
  std::set<std::string> present;
  collect(root, present);
  const std::set<std::string> declared = texts(root, "extensionsUsed");
  for (const std::string& name : present) {
    if (!declared.contains(name)) context.warn("the extension {} is used but not listed in extensionsUsed", name);
  }
  names.insert(declared.begin(), declared.end());
  names.insert(present.begin(), present.end());
  ExtensionLists lists;
  for (const std::string& name : names) {
    lists.used.push_back(name);
    const Known* extension = find_known(name);
    if (extension && extension->support == Support::full) continue;
    lists.ignored.push_back(name);
    if (!extension)
      context.warn("the unknown extension {} was ignored", name);
    else if (extension->support == Support::look)
      context.warn("{} is ignored: {}", name, extension->note);
    else if (extension->support == Support::default_)
      context.warn("{}: {}", name, extension->note);
    else if (extension->support == Support::needed)
      context.warn("{} is ignored: uncompressed data are read", name);
  }
  return lists;
}

}  // namespace lucarium::gltf
