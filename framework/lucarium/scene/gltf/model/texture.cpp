// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/gltf/model/texture.h"

#include <algorithm>
#include <bit>

#include "lucarium/base/hash.h"
#include "lucarium/base/text/byte_size.h"
#include "lucarium/compute/device/host_memory.h"
#include "lucarium/scene/image/image_decode.h"

namespace lucarium::gltf {

namespace {

constexpr uint64_t max_image_file_bytes = 1ull << 31;

Wrap wrap_mode(int mode) {
  if (mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return Wrap::clamp;
  return mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? Wrap::mirror : Wrap::repeat;
}

constexpr uint64_t warned_share = 4;  // textures draw a warning above this part of the maximum

glm::vec2 vec2_or(const tinygltf::Value& object, const char* key, glm::vec2 fallback) {
  if (!object.Has(key)) return fallback;
  const tinygltf::Value& v = object.Get(key);
  return {v.Get(0).GetNumberAsDouble(), v.Get(1).GetNumberAsDouble()};
}

}  // namespace

TextureImporter::TextureImporter(const Document& document, Scene& scene, ImportContext& context)
    : document_(document),
      scene_(scene),
      context_(context),
      limit_(std::min<uint64_t>(context.options.max_texture_bytes, available_host_memory() / 2)) {}

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

TextureImporter::Encoded TextureImporter::read(int index) const {
  const ImageSource& source = document_.images[index];
  Encoded result;
  result.where = "/images/" + std::to_string(index);
  result.name = !source.name.empty() ? source.name : source.uri;
  if (result.name.empty() || result.name.starts_with("data:")) result.name = fmt::format("image {}", index);
  if (source.buffer_view != none) {
    const std::string_view view = view_bytes(document_, source.buffer_view, result.where, context_);
    result.bytes = {reinterpret_cast<const uint8_t*>(view.data()), view.size()};
  } else if (!source.uri.empty()) {
    result.loaded = read_uri(source.uri, document_.folder, max_image_file_bytes, result.where, context_);
    result.bytes = result.loaded;
  } else {
    context_.fail("{} has neither a uri nor a bufferView", result.where);
  }
  return result;
}

int TextureImporter::image(int index) {
  const auto known = images_.find(index);
  if (known != images_.end()) return known->second;
  const Encoded encoded = read(index);
  const int next = static_cast<int>(scene_.images.size());
  const std::string_view bytes(reinterpret_cast<const char*>(encoded.bytes.data()), encoded.bytes.size());
  const auto [same, fresh] = contents_.try_emplace(Hasher().add(bytes).finish().hex(), next);
  images_[index] = same->second;
  if (!fresh) return same->second;
  count(decoded_size(encoded.bytes, context_.name() + ": " + encoded.label(), context_.options));
  pending_[next] = index;
  scene_.images.emplace_back();
  return next;
}

uint32_t TextureImporter::smaller_size() const { return std::max(1u, std::bit_floor(largest_side_ - 1)); }

void TextureImporter::count(ImageSize size) {
  bytes_ += 4 * size.pixels();
  largest_side_ = std::max({largest_side_, size.width, size.height});
  if (bytes_ <= limit_) return;
  context_.fail("its textures need more than {} together, which is {}; scale them down with --texture-size {}",
                format_bytes(limit_),
                limit_ == context_.options.max_texture_bytes ? "the maximum" : "half of the memory that is free",
                smaller_size());
}

void TextureImporter::decode(int scene_texture) {
  const int index = scene_.textures[scene_texture].image;
  const auto entry = pending_.find(index);
  if (entry == pending_.end()) return;
  const Encoded encoded = read(entry->second);
  DecodedImage decoded = decode_image(encoded.bytes, context_.name() + ": " + encoded.label(), context_.options);
  if (decoded.shrunk) {
    context_.warn("{} was scaled down to {}x{}, the limit being {}", encoded.label(), decoded.image.width,
                  decoded.image.height, context_.options.max_texture_size);
  }
  decoded.image.name = encoded.name;
  scene_.images[index] = std::move(decoded.image);
  pending_.erase(entry);
}

void TextureImporter::decode_all() {
  if (bytes_ > context_.options.max_texture_bytes / warned_share) {
    context_.warn("its textures take {} together; --texture-size {} takes less memory and time", format_bytes(bytes_),
                  smaller_size());
  }
  for (size_t texture = 0; texture < scene_.textures.size(); ++texture) decode(static_cast<int>(texture));
}

}  // namespace lucarium::gltf
