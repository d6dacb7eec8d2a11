// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/device/emission.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "lucarium/scene/device/texture_sampling.h"

namespace lucarium {

namespace {

constexpr int max_subdivision = 64;  // rows of samples in one triangle

/// A range of texel indices along one axis, grown by the bilinear footprint; never longer than all there is.
struct TexelRange {
  int64_t first, count;
  bool whole;
};

TexelRange texel_range(double low, double high, int64_t texels, Wrap mode) {
  TexelRange range;
  low = std::clamp(low, -1e9, 1e9), high = std::clamp(high, -1e9, 1e9);
  range.first = static_cast<int64_t>(std::floor(low * static_cast<double>(texels))) - 1;
  range.count = static_cast<int64_t>(std::floor(high * static_cast<double>(texels))) + 2 - range.first;
  range.whole = range.count >= (mode == Wrap::mirror ? 2 * texels : texels + 2);
  if (mode == Wrap::clamp && !range.whole) {
    // Beyond the border there is nothing new.
    range.first = std::clamp<int64_t>(range.first, -1, texels - range.count + 1);
  }
  return range;
}

glm::vec3 mean_of_texels(const Scene& scene, const SceneTexture& texture, const TexelRange& x, const TexelRange& y) {
  glm::dvec3 sum(0);
  for (int64_t j = 0; j < y.count; ++j) {
    for (int64_t i = 0; i < x.count; ++i) {
      sum += glm::dvec3(glm::vec3(fetch_texel(scene, texture, x.first + i, y.first + j)));
    }
  }
  return glm::vec3(sum / static_cast<double>(x.count * y.count));
}

}  // namespace

glm::vec3 EmissionEstimator::mean_over_rectangle(int texture_index, const glm::vec2 uv[3]) {
  const SceneTexture& texture = scene_.textures[texture_index];
  const Image& image = scene_.images[texture.image];
  const glm::vec2 low = glm::min(uv[0], glm::min(uv[1], uv[2])), high = glm::max(uv[0], glm::max(uv[1], uv[2]));
  const TexelRange x = texel_range(low.x, high.x, image.width, texture.wrap_u);
  const TexelRange y = texel_range(low.y, high.y, image.height, texture.wrap_v);
  auto whole = whole_texture_.find(texture_index);
  if (whole == whole_texture_.end()) {
    const TexelRange all_x{0, image.width, true}, all_y{0, image.height, true};
    whole = whole_texture_.emplace(texture_index, mean_of_texels(scene_, texture, all_x, all_y)).first;
  }
  if ((x.whole && y.whole) || whole->second == glm::vec3(0)) return whole->second;
  return mean_of_texels(scene_, texture, x, y);
}

glm::vec3 EmissionEstimator::mean_radiance(const Mesh& mesh, const glm::uvec3& triangle,
                                           const SceneMaterial& material) {
  if (!material.emits()) return glm::vec3(0);
  const glm::vec3 factor =
      material.unlit ? glm::vec3(material.base_color) : material.emissive_factor * material.emissive_strength;
  const TextureUse& use = material.unlit ? material.base_color_texture : material.emissive_texture;
  const bool colored = material.unlit && !mesh.colors.empty();
  const bool has_uv = use.texture != none && !mesh.uv[use.uv_set].empty();
  const SceneTexture* texture = use.texture == none ? nullptr : &scene_.textures[use.texture];
  if (!colored && !texture) return factor;

  // Choose the number of samples by the footprint's longest side in texels: about two samples per texel.
  glm::vec2 uv[3] = {};
  int n = colored ? 4 : 1;
  if (texture) {
    const TextureTransform transform = texture_transform(use);
    for (int i = 0; i < 3; ++i) uv[i] = transform(has_uv ? mesh.uv[use.uv_set][triangle[i]] : glm::vec2(0));
    const glm::vec2 size(scene_.images[texture->image].width, scene_.images[texture->image].height);
    float longest = 0;
    for (int i = 0; i < 3; ++i) longest = std::max(longest, glm::length((uv[(i + 1) % 3] - uv[i]) * size));
    n = std::max(n, static_cast<int>(std::min(2 * longest + 2, static_cast<float>(max_subdivision))));
  }

  // Average over the centroids of n² congruent triangles.
  glm::dvec3 sum(0);
  const float step = 1.f / static_cast<float>(n);
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column < 2 * (n - row) - 1; ++column) {
      const float third = (column & 1) ? 2.f / 3.f : 1.f / 3.f;
      const float b = (static_cast<float>(column / 2) + third) * step, c = (static_cast<float>(row) + third) * step;
      const float a = 1 - b - c;
      glm::vec3 value(1);
      if (texture) value *= glm::vec3(sample_texture(scene_, *texture, a * uv[0] + b * uv[1] + c * uv[2]));
      if (colored) {
        value *= glm::vec3(a * mesh.colors[triangle.x] + b * mesh.colors[triangle.y] + c * mesh.colors[triangle.z]);
      }
      sum += glm::dvec3(value);
    }
  }
  glm::vec3 mean = factor * glm::vec3(sum / static_cast<double>(n * n));
  if (mean == glm::vec3(0) && texture) mean = factor * mean_over_rectangle(use.texture, uv);
  return mean;
}

glm::vec2 spot_ramp(const SceneLight& light) {
  const float cos_inner = std::cos(light.inner_angle), cos_outer = std::cos(light.outer_angle);
  const float scale = 1.f / std::max(0.001f, cos_inner - cos_outer);
  return {scale, -cos_outer * scale};
}

double spot_solid_angle(const SceneLight& light) {
  // ∫ clamp((c − c_o)/(c_i − c_o), 0, 1)² dω with c_i = c_o + max(.001, cos inner − cos outer); c_i may exceed 1.
  const double cos_outer = std::cos(static_cast<double>(light.outer_angle));
  const double width = std::max(0.001, std::cos(static_cast<double>(light.inner_angle)) - cos_outer);
  const double top = cos_outer + width;
  if (top > 1) return 2 * glm::pi<double>() * std::pow(1 - cos_outer, 3) / (3 * width * width);
  return 2 * glm::pi<double>() * (1 - top + width / 3);
}

}  // namespace lucarium
