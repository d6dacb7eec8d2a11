// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/device/texture_sampling.h"

#include <algorithm>
#include <cmath>

#include "lucarium/base/srgb.h"

namespace lucarium {

namespace {

int64_t wrap(int64_t i, int64_t size, Wrap mode) {
  if (mode == Wrap::clamp) return std::clamp<int64_t>(i, 0, size - 1);
  const int64_t period = mode == Wrap::repeat ? size : 2 * size;
  const int64_t folded = ((i % period) + period) % period;
  return folded < size ? folded : period - 1 - folded;
}

}  // namespace

const std::array<float, 256>& srgb_to_linear_table() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> values{};
    for (int i = 0; i < 256; ++i) {
      values[i] = static_cast<float>(linear_from_srgb(i / 255.0));
    }
    return values;
  }();
  return table;
}

TextureTransform texture_transform(const TextureUse& use) {
  const float c = std::cos(use.rotation), s = std::sin(use.rotation);
  return {{c * use.scale.x, s * use.scale.y, use.offset.x}, {-s * use.scale.x, c * use.scale.y, use.offset.y}};
}

glm::vec4 fetch_texel(const Scene& scene, const SceneTexture& texture, int64_t x, int64_t y) {
  const Image& image = scene.images[texture.image];
  const int64_t column = wrap(x, image.width, texture.wrap_u), row = wrap(y, image.height, texture.wrap_v);
  const uint8_t* texel = image.rgba.data() + 4 * (static_cast<size_t>(row) * image.width + column);
  glm::vec4 value;
  for (int c = 0; c < 4; ++c) {
    value[c] = texture.srgb && c < 3 ? srgb_to_linear_table()[texel[c]] : static_cast<float>(texel[c]) / 255.f;
  }
  return value;
}

glm::vec4 sample_texture(const Scene& scene, const SceneTexture& texture, const glm::vec2& uv) {
  const Image& image = scene.images[texture.image];
  // Wild coordinates are legal; keep them inside the range of the integers below.
  const double x = std::clamp(static_cast<double>(uv.x) * image.width, -1e15, 1e15);
  const double y = std::clamp(static_cast<double>(uv.y) * image.height, -1e15, 1e15);
  if (texture.nearest) {
    return fetch_texel(scene, texture, static_cast<int64_t>(std::floor(x)), static_cast<int64_t>(std::floor(y)));
  }
  const double left = std::floor(x - 0.5), top = std::floor(y - 0.5);
  const float fx = static_cast<float>(x - 0.5 - left), fy = static_cast<float>(y - 0.5 - top);
  const int64_t i = static_cast<int64_t>(left), j = static_cast<int64_t>(top);
  return (1 - fy) * ((1 - fx) * fetch_texel(scene, texture, i, j) + fx * fetch_texel(scene, texture, i + 1, j)) +
         fy * ((1 - fx) * fetch_texel(scene, texture, i, j + 1) + fx * fetch_texel(scene, texture, i + 1, j + 1));
}

}  // namespace lucarium
