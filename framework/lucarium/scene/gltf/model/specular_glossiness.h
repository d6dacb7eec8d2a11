// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/scene/gltf/model/texture.h"

namespace lucarium::gltf {

/// Sets base colour, metallic and roughness of `material` from KHR_materials_pbrSpecularGlossiness, per texel where
/// there is a specular-glossiness map. Diffuse and specular colour are kept as well as a metallic-roughness material
/// over a dielectric of reflectance 0.04 can.
void convert_specular_glossiness(const tinygltf::Value& extension, const std::string& where, bool with_textures,
                                 TextureImporter& textures, Scene& scene, SceneMaterial& material,
                                 ImportContext& context);

}  // namespace lucarium::gltf
