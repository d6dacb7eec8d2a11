// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <span>
#include <tuple>

#include "lucarium/film/encoded_image.h"
#include "lucarium/scene/gltf/document/document.h"

namespace lucarium::gltf {

/// Makes the scene's textures as materials ask for them. Of an image only the header is read then, so that a scene
/// whose textures need too much memory together is refused before anything is decoded; decode_all() fills in the
/// pixels. The same bytes are one image, whatever names they have.
class TextureImporter {
 public:
  TextureImporter(const Document& document, Scene& scene, ImportContext& context);

  /// The use of a texture in a material, from its textureInfo (a core one, or one inside an extension); without
  /// effect where there is none, or where the texture has no image that can be read and need not have.
  template <class Info>
  TextureUse use(const Info& info, bool srgb, const std::string& where) {
    if (info.index == none) return {};
    return make_use(info.index, info.texCoord, extension(info.extensions, "KHR_texture_transform"), srgb, where);
  }
  TextureUse use(const tinygltf::Value& parent, const char* key, bool srgb, const std::string& where);

  /// Fills in the pixels of the image of a texture, for who needs them before all are decoded.
  void decode(int scene_texture);
  /// Fills in the pixels of all images that were asked for. Warns where they take more than a quarter of the maximum.
  void decode_all();
  /// Adds an image of that size to the sum. Throws Error{input}, which names --texture-size, where it is too large.
  void count(ImageSize size);

 private:
  struct Encoded {
    std::string where, name;  ///< "/images/3", and what it is called in messages
    Bytes loaded;             ///< of a file or a data URI
    std::span<const uint8_t> bytes;
    std::string label() const { return where + " ('" + name + "')"; }
  };

  /// Index in scene.images of a glTF image.
  int image(int gltf_image);
  Encoded read(int gltf_image) const;
  TextureUse make_use(int texture, int uv_set, const tinygltf::Value* transform, bool srgb, const std::string& where);
  int texture(int gltf_texture, bool srgb);
  int readable_source(int gltf_texture);
  uint32_t smaller_size() const;  ///< for --texture-size, so that the largest image is scaled down

  const Document& document_;
  Scene& scene_;
  ImportContext& context_;
  std::map<int, int> images_;                                        ///< glTF image → scene image
  std::map<std::string, int> contents_;                              ///< hash of encoded bytes → scene image
  std::map<int, int> pending_;                                       ///< scene image without pixels → glTF image
  std::map<std::tuple<int, Wrap, Wrap, bool, bool>, int> textures_;  ///< image, wraps, nearest, sRGB → scene texture
  uint64_t bytes_ = 0, limit_;                                       ///< of all images, decoded
  uint32_t largest_side_ = 1;                                        ///< of an image [pixels]
};

}  // namespace lucarium::gltf
