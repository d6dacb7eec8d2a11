// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <tuple>

#include "lucarium/scene/gltf/document.h"

namespace lucarium::gltf {

/// Decodes images and makes the scene's textures as materials ask for them; each image is decoded once.
class TextureImporter {
 public:
  TextureImporter(const Document& document, Scene& scene, ImportContext& context)
      : document_(document), scene_(scene), context_(context) {}

  /// The use of a texture in a material, from its textureInfo (a core one, or one inside an extension); without
  /// effect where there is none, or where the texture has no image that can be read and need not have.
  template <class Info>
  TextureUse use(const Info& info, bool srgb, const std::string& where) {
    if (info.index == none) return {};
    return make_use(info.index, info.texCoord, extension(info.extensions, "KHR_texture_transform"), srgb, where);
  }
  TextureUse use(const tinygltf::Value& parent, const char* key, bool srgb, const std::string& where);

  /// Index in scene.images of a glTF image; decodes it when it is first asked for.
  int image(int gltf_image);

 private:
  TextureUse make_use(int texture, int uv_set, const tinygltf::Value* transform, bool srgb, const std::string& where);
  int texture(int gltf_texture, bool srgb);
  int readable_source(int gltf_texture);

  const Document& document_;
  Scene& scene_;
  ImportContext& context_;
  std::map<int, int> images_;
  std::map<std::tuple<int, Wrap, Wrap, bool, bool>, int> textures_;  ///< image, wraps, nearest, sRGB → scene texture
  uint64_t pixels_ = 0;
};

}  // namespace lucarium::gltf
