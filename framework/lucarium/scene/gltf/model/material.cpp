// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/gltf/model/material.h"

#include <algorithm>
#include <cmath>

#include "lucarium/scene/gltf/model/specular_glossiness.h"
#include "lucarium/scene/gltf/model/texture.h"

namespace lucarium::gltf {

namespace {

/// Reads one material; `where` is its label in messages.
class MaterialReader {
 public:
  MaterialReader(const tinygltf::Material& source, std::string where, bool with_textures, TextureImporter& textures,
                 Scene& scene, ImportContext& context)
      : source_(source),
        where_(std::move(where)),
        with_textures_(with_textures),
        textures_(textures),
        scene_(scene),
        context_(context) {}

  SceneMaterial read() {
    material_.name = source_.name;
    read_metallic_roughness();
    read_emission();
    read_visibility();
    read_transmission();
    if (const auto* value = find("KHR_materials_pbrSpecularGlossiness")) {
      convert_specular_glossiness(*value, where_, with_textures_, textures_, scene_, material_, context_);
    }
    return material_;
  }

 private:
  const tinygltf::Value* find(const char* name) const { return extension(source_.extensions, name); }

  /// Clamps with a warning.
  float limited(double value, double low, double high, const char* what) {
    const double inside = std::clamp(value, low, high);
    if (inside != value) context_.warn("{}: {} {} was clamped to {}", where_, what, value, inside);
    return static_cast<float>(inside);
  }

  template <class Info>
  TextureUse texture(const Info& info, bool srgb) {
    return with_textures_ ? textures_.use(info, srgb, where_) : TextureUse{};
  }
  TextureUse texture(const tinygltf::Value& parent, const char* key, bool srgb) {
    return with_textures_ ? textures_.use(parent, key, srgb, where_) : TextureUse{};
  }

  void read_metallic_roughness() {
    const tinygltf::PbrMetallicRoughness& pbr = source_.pbrMetallicRoughness;
    for (int c = 0; c < 4; ++c) material_.base_color[c] = limited(pbr.baseColorFactor[c], 0, 1, "baseColorFactor");
    material_.metallic = limited(pbr.metallicFactor, 0, 1, "metallicFactor");
    material_.roughness = limited(pbr.roughnessFactor, 0, 1, "roughnessFactor");
    material_.base_color_texture = texture(pbr.baseColorTexture, true);
    material_.metallic_roughness_texture = texture(pbr.metallicRoughnessTexture, false);
    material_.normal_texture = texture(source_.normalTexture, false);
    if (material_.normal_texture.texture != none) {
      material_.normal_texture.strength = static_cast<float>(source_.normalTexture.scale);
    }
    if (with_textures_ && source_.occlusionTexture.index >= 0) {
      context_.warn("occlusion textures are ignored: techniques compute occlusion from the geometry");
    }
    material_.unlit = find("KHR_materials_unlit") != nullptr;
  }

  /// Factors above 1 are outside of glTF's range, but older exporters write lamps so: they are kept.
  void read_emission() {
    for (size_t c = 0; c < source_.emissiveFactor.size() && c < 3; ++c) {
      material_.emissive_factor[static_cast<int>(c)] = limited(source_.emissiveFactor[c], 0, 1e30, "emissiveFactor");
    }
    if (const auto* value = find("KHR_materials_emissive_strength")) {
      material_.emissive_strength = limited(number_or(*value, "emissiveStrength", 1), 0, 1e30, "emissiveStrength");
    }
    material_.emissive_texture = texture(source_.emissiveTexture, true);
  }

  void read_visibility() {
    material_.double_sided = source_.doubleSided;
    material_.alpha_cutoff = static_cast<float>(std::max(source_.alphaCutoff, 0.0));
    if (source_.alphaMode == "MASK")
      material_.alpha_mode = AlphaMode::mask;
    else if (source_.alphaMode == "BLEND")
      material_.alpha_mode = AlphaMode::blend;
    else if (source_.alphaMode != "OPAQUE")
      context_.warn("{}: the unknown alphaMode '{}' is taken as OPAQUE", where_, source_.alphaMode);
  }

  void read_transmission() {
    if (const auto* value = find("KHR_materials_ior")) {
      const double ior = number_or(*value, "ior", 1.5);
      // 0 asks for a Fresnel term of 1 (for converted specular-glossiness materials).
      if (ior == 0) context_.warn("{}: an index of refraction of 0 is taken as 1.5", where_);
      material_.ior = ior == 0 ? 1.5f : limited(ior, 1, 100, "index of refraction");
    }
    if (const auto* value = find("KHR_materials_transmission")) {
      material_.transmission = limited(number_or(*value, "transmissionFactor", 0), 0, 1, "transmissionFactor");
      material_.transmission_texture = texture(*value, "transmissionTexture", false);
    }
    const auto* volume = find("KHR_materials_volume");
    if (!volume) return;
    material_.thickness = limited(number_or(*volume, "thicknessFactor", 0), 0, 1e30, "thicknessFactor");
    if (volume->Has("thicknessTexture"))
      context_.warn("{}: the thickness texture is ignored: rays measure the thickness", where_);
    if (volume->Has("attenuationDistance")) {
      const double distance = volume->Get("attenuationDistance").GetNumberAsDouble();
      if (distance > 0)
        material_.attenuation_distance = static_cast<float>(distance);
      else
        context_.warn("{}: attenuationDistance {} is taken as infinite", where_, distance);
    }
    if (volume->Has("attenuationColor")) {
      for (int c = 0; c < 3; ++c) {
        material_.attenuation_color[c] =
            limited(volume->Get("attenuationColor").Get(c).GetNumberAsDouble(), 0, 1, "attenuationColor");
      }
    }
  }

  const tinygltf::Material& source_;
  std::string where_;
  bool with_textures_;
  TextureImporter& textures_;
  Scene& scene_;
  ImportContext& context_;
  SceneMaterial material_;
};

}  // namespace

void import_materials(const Document& document, const std::vector<bool>& used, Scene& scene, ImportContext& context) {
  TextureImporter textures(document, scene, context);
  for (size_t i = 0; i < document.model.materials.size(); ++i) {
    const tinygltf::Material& source = document.model.materials[i];
    MaterialReader reader(source, label("material", i, source.name), used[i], textures, scene, context);
    scene.materials.push_back(reader.read());
    if (scene.materials.back().name.empty()) scene.materials.back().name = fmt::format("material {}", i);
  }
  textures.decode_all();
}

}  // namespace lucarium::gltf
