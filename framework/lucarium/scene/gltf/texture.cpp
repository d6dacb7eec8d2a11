// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/gltf/texture.h"

#include <algorithm>

#include "lucarium/scene/image/image_decode.h"

namespace lucarium::gltf {

namespace {

constexpr uint64_t max_image_file_bytes = 1ull << 31;
constexpr uint64_t max_images_full_size = 8;  ///< all images together, in units of options.max_image_pixels

Wrap wrap_mode(int mode) {
  if (mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return Wrap::clamp;
  return mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? Wrap::mirror : Wrap::repeat;
}

glm::vec2 vec2_or(const tinygltf::Value& object, const char* key, glm::vec2 fallback) {
  if (!object.Has(key)) return fallback;
  const tinygltf::Value& v = object.Get(key);
  return {v.Get(0).GetNumberAsDouble(), v.Get(1).GetNumberAsDouble()};
}

}  // namespace

TextureUse TextureImporter::use(const tinygltf::Value& parent, const char* key, bool srgb, const std::string& where) {
  if (!parent.Has(key)) return {};
  const tinygltf::Value& info = parent.Get(key);
  const tinygltf::Value* transform = nullptr;
  if (info.Has("extensions") && info.Get("extensions").Has("KHR_texture_transform")) {
    transform = &info.Get("extensions").Get("KHR_texture_transform");
  }
  const int uv_set = info.Has("texCoord") ? info.Get("texCoord").GetNumberAsInt() : 0;
  return make_use(index_or_none(info, "index"), uv_set, transform, srgb, where);
}

TextureUse TextureImporter::make_use(int gltf_texture, int uv_set, const tinygltf::Value* transform, bool srgb,
                                     const std::string& where) {
  TextureUse use;
  use.texture = texture(gltf_texture, srgb);
  if (use.texture == none) return {};
  if (transform) {
    use.offset = vec2_or(*transform, "offset", glm::vec2(0));
    use.scale = vec2_or(*transform, "scale", glm::vec2(1));
    use.rotation = static_cast<float>(number_or(*transform, "rotation", 0));
    if (transform->Has("texCoord")) uv_set = transform->Get("texCoord").GetNumberAsInt();
  }
  if (uv_set > 1) {
    context_.warn("{} uses TEXCOORD_{}: only the sets 0 and 1 are supported, so set 0 is taken", where, uv_set);
    uv_set = 0;
  }
  use.uv_set = uv_set;
  return use;
}

int TextureImporter::readable_source(int index) {
  const tinygltf::Texture& source = document_.model.textures[index];
  if (source.source >= static_cast<int>(document_.images.size())) {
    context_.warn("/textures/{}/source refers to /images/{}, which does not exist; the texture was left out", index,
                  source.source);
    return none;
  }
  if (source.source != none) return source.source;
  for (const char* name : {"EXT_texture_webp", "KHR_texture_basisu"}) {
    if (!extension(source.extensions, name)) continue;
    const auto& required = document_.model.extensionsRequired;
    if (std::find(required.begin(), required.end(), name) != required.end()) {
      context_.fail(
          "/textures/{} has only an image of the required extension {}, which is not supported; export the "
          "textures as PNG or JPEG",
          index, name);
    }
    context_.warn("/textures/{} has only an image of the unsupported extension {}; it was left out", index, name);
    return none;
  }
  context_.warn("/textures/{} has no image; it was left out", index);
  return none;
}

int TextureImporter::texture(int index, bool srgb) {
  const int source = readable_source(index);
  if (source == none) return none;
  SceneTexture texture;
  texture.srgb = srgb;
  if (const int sampler = document_.model.textures[index].sampler; sampler != none) {
    const tinygltf::Sampler& state = document_.model.samplers[sampler];
    texture.wrap_u = wrap_mode(state.wrapS);
    texture.wrap_v = wrap_mode(state.wrapT);
    texture.nearest = state.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
  }
  texture.image = image(source);
  const auto key = std::tuple(texture.image, texture.wrap_u, texture.wrap_v, texture.nearest, texture.srgb);
  const auto [entry, fresh] = textures_.try_emplace(key, static_cast<int>(scene_.textures.size()));
  if (fresh) scene_.textures.push_back(texture);
  return entry->second;
}

int TextureImporter::image(int index) {
  const auto [entry, fresh] = images_.try_emplace(index, static_cast<int>(scene_.images.size()));
  if (!fresh) return entry->second;
  const ImageSource& source = document_.images[index];
  const std::string where = "/images/" + std::to_string(index);
  Bytes loaded;
  std::span<const uint8_t> encoded;
  if (source.buffer_view != none) {
    const std::string_view view = view_bytes(document_, source.buffer_view, where, context_);
    encoded = {reinterpret_cast<const uint8_t*>(view.data()), view.size()};
  } else if (!source.uri.empty()) {
    loaded = read_uri(source.uri, document_.folder, max_image_file_bytes, where, context_);
    encoded = loaded;
  } else {
    context_.fail("{} has neither a uri nor a bufferView", where);
  }
  std::string name = !source.name.empty() ? source.name : source.uri;
  if (name.empty() || name.starts_with("data:")) name = fmt::format("image {}", index);
  DecodedImage decoded =
      decode_image(encoded, fmt::format("{}: {} ('{}')", context_.name(), where, name), context_.options);
  Image& image = decoded.image;
  if (decoded.shrunk) {
    context_.warn("{} ('{}') was scaled down to {}x{}, the limit being {}", where, name, image.width, image.height,
                  context_.options.max_texture_size);
  }
  image.name = name;
  pixels_ += static_cast<uint64_t>(image.width) * image.height;
  if (pixels_ > max_images_full_size * context_.options.max_image_pixels) {
    context_.fail("its images have more than {} pixels together; scale them down",
                  max_images_full_size * context_.options.max_image_pixels);
  }
  scene_.images.push_back(std::move(image));
  return entry->second;
}

}  // namespace lucarium::gltf
