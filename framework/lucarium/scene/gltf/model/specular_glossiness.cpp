// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/gltf/model/specular_glossiness.h"

#include <algorithm>
#include <cmath>

#include "lucarium/base/srgb.h"
#include "lucarium/scene/device/texture_sampling.h"

namespace lucarium::gltf {

namespace {

constexpr float dielectric = 0.04f;

struct MetallicRoughness {
  glm::vec3 base_color;
  float metallic;
};

float luma(const glm::vec3& c) { return std::sqrt(0.299f * c.r * c.r + 0.587f * c.g * c.g + 0.114f * c.b * c.b); }
float largest(const glm::vec3& c) { return std::max({c.r, c.g, c.b}); }

/// With b the base colour and m metallic: diffuse d(1 − max s) = b(1 − f)(1 − m) and specular s = f(1 − m) + b m.
/// Eliminating b (by perceived brightness) leaves a quadratic equation in m.
MetallicRoughness convert(const glm::vec3& diffuse, const glm::vec3& specular) {
  const float one_minus_specular = 1.f - largest(specular), d = luma(diffuse), s = luma(specular);
  float m = 0;
  if (s >= dielectric) {
    const float b = d * one_minus_specular / (1 - dielectric) + s - 2 * dielectric, c = dielectric - s;
    m = std::clamp((-b + std::sqrt(std::max(b * b - 4 * dielectric * c, 0.f))) / (2 * dielectric), 0.f, 1.f);
  }
  const glm::vec3 from_diffuse = diffuse * (one_minus_specular / (1 - dielectric) / std::max(1 - m, 1e-4f));
  const glm::vec3 from_specular = (specular - dielectric * (1 - m)) / std::max(m, 1e-4f);
  return {glm::clamp(glm::mix(from_diffuse, from_specular, m * m), 0.f, 1.f), m};
}

glm::vec3 color_or_white(const tinygltf::Value& object, const char* key) {
  glm::vec3 color(1);
  if (!object.Has(key)) return color;
  for (int c = 0; c < 3; ++c) {
    color[c] = static_cast<float>(std::clamp(object.Get(key).Get(c).GetNumberAsDouble(), 0.0, 1.0));
  }
  return color;
}

uint8_t to_byte(float linear) { return static_cast<uint8_t>(std::lround(std::clamp(linear, 0.f, 1.f) * 255.f)); }
uint8_t to_srgb_byte(float linear) { return to_byte(static_cast<float>(srgb_from_linear(linear))); }

/// Appends an image as a texture that is sampled like `model`.
int add_texture(Scene& scene, Image image, const SceneTexture& model, bool srgb) {
  SceneTexture texture = model;
  texture.image = static_cast<int>(scene.images.size());
  texture.srgb = srgb;
  scene.images.push_back(std::move(image));
  scene.textures.push_back(texture);
  return static_cast<int>(scene.textures.size()) - 1;
}

/// Replaces both maps by a base colour and a metallic-roughness map with the resolution of the latter.
void convert_texels(const TextureUse& diffuse_use, const TextureUse& specular_use, const glm::vec3& diffuse_factor,
                    const glm::vec3& specular_factor, float glossiness, Scene& scene, SceneMaterial& material) {
  const SceneTexture specular_texture = scene.textures[specular_use.texture];
  Image base, other;
  base.width = other.width = scene.images[specular_texture.image].width;
  base.height = other.height = scene.images[specular_texture.image].height;
  base.name = scene.images[specular_texture.image].name + " (base colour)";
  other.name = scene.images[specular_texture.image].name + " (metallic, roughness)";
  base.rgba.reserve(4 * static_cast<size_t>(base.width) * base.height);
  other.rgba.reserve(base.rgba.capacity());
  for (uint32_t y = 0; y < base.height; ++y) {
    for (uint32_t x = 0; x < base.width; ++x) {
      const glm::vec2 uv((static_cast<float>(x) + 0.5f) / static_cast<float>(base.width),
                         (static_cast<float>(y) + 0.5f) / static_cast<float>(base.height));
      const glm::vec4 specular = fetch_texel(scene, specular_texture, x, y);
      const glm::vec4 diffuse =
          diffuse_use.texture == none ? glm::vec4(1) : sample_texture(scene, scene.textures[diffuse_use.texture], uv);
      const MetallicRoughness result =
          convert(diffuse_factor * glm::vec3(diffuse), specular_factor * glm::vec3(specular));
      for (int c = 0; c < 3; ++c) base.rgba.push_back(to_srgb_byte(result.base_color[c]));
      base.rgba.push_back(to_byte(diffuse.a));
      const float roughness = 1.f - glossiness * specular.a;
      other.rgba.insert(other.rgba.end(), {0, to_byte(roughness), to_byte(result.metallic), 255});
    }
  }
  material.base_color = glm::vec4(1, 1, 1, material.base_color.a);
  material.metallic = material.roughness = 1;
  material.base_color_texture = material.metallic_roughness_texture = specular_use;
  material.base_color_texture.texture = add_texture(scene, std::move(base), specular_texture, true);
  material.metallic_roughness_texture.texture = add_texture(scene, std::move(other), specular_texture, false);
}

bool same_mapping(const TextureUse& a, const TextureUse& b) {
  return a.uv_set == b.uv_set && a.offset == b.offset && a.scale == b.scale && a.rotation == b.rotation;
}

}  // namespace

void convert_specular_glossiness(const tinygltf::Value& extension, const std::string& where, bool with_textures,
                                 TextureImporter& textures, Scene& scene, SceneMaterial& material,
                                 ImportContext& context) {
  const glm::vec3 diffuse = color_or_white(extension, "diffuseFactor"),
                  specular = color_or_white(extension, "specularFactor");
  const float glossiness = static_cast<float>(std::clamp(number_or(extension, "glossinessFactor", 1), 0.0, 1.0));
  float alpha = 1;
  if (extension.Has("diffuseFactor")) {
    alpha = static_cast<float>(std::clamp(extension.Get("diffuseFactor").Get(3).GetNumberAsDouble(), 0.0, 1.0));
  }
  const MetallicRoughness factors = convert(diffuse, specular);
  material.base_color = glm::vec4(factors.base_color, alpha);
  material.metallic = factors.metallic;
  material.roughness = 1 - glossiness;
  material.base_color_texture = material.metallic_roughness_texture = TextureUse{};
  context.warn("{}: specular-glossiness was converted to metallic-roughness", where);
  if (!with_textures) return;
  const TextureUse diffuse_use = textures.use(extension, "diffuseTexture", true, where);
  const TextureUse specular_use = textures.use(extension, "specularGlossinessTexture", true, where);
  material.base_color_texture = diffuse_use;
  if (specular_use.texture == none) return;
  if (diffuse_use.texture != none && !same_mapping(diffuse_use, specular_use)) {
    context.warn("{}: its diffuse and specular maps are placed differently; the specular map was ignored", where);
    return;
  }
  textures.decode(specular_use.texture);
  if (diffuse_use.texture != none) textures.decode(diffuse_use.texture);
  const Image& model = scene.images[scene.textures[specular_use.texture].image];
  for (int added = 0; added < 2; ++added) textures.count({model.width, model.height});
  convert_texels(diffuse_use, specular_use, diffuse, specular, glossiness, scene, material);
}

}  // namespace lucarium::gltf
