// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <glm/glm.hpp>

#include "lucarium/scene/scene.h"

namespace lucarium {

/// Byte → linear value of the sRGB transfer function (IEC 61966-2-1).
const std::array<float, 256>& srgb_to_linear_table();

/// Rows of the affine map of KHR_texture_transform, u' = row_u · (u, v, 1): scale, then a counter-clockwise turn as
/// seen in the image (v points down), then the offset.
struct TextureTransform {
  glm::vec3 row_u{1, 0, 0}, row_v{0, 1, 0};
  glm::vec2 operator()(const glm::vec2& uv) const {
    return {glm::dot(row_u, glm::vec3(uv, 1)), glm::dot(row_v, glm::vec3(uv, 1))};
  }
};
TextureTransform texture_transform(const TextureUse& use);

/// Linear RGBA of one texel; x and y may lie outside and are wrapped as the texture says.
glm::vec4 fetch_texel(const Scene& scene, const SceneTexture& texture, int64_t x, int64_t y);

/// Bilinear lookup as kernels do it (texel centres at half integers), or nearest.
glm::vec4 sample_texture(const Scene& scene, const SceneTexture& texture, const glm::vec2& uv);

}  // namespace lucarium
