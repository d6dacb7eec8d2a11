// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstdint>

namespace lucarium {

constexpr int kMaxAtlasTexels = 1 << 24;  ///< that techniques ask for, and states may be of

/// Texel sides that suit an image of so many pixels: eight for each, but no fewer than a quarter of the scene's
/// triangles, since detail much finer than texels comes out too dark.
constexpr uint64_t suitable_texels(uint64_t pixels, uint64_t triangles) {
  return std::clamp<uint64_t>(std::max(8 * pixels, triangles / 4), 32768, 262144);
}

}  // namespace lucarium
