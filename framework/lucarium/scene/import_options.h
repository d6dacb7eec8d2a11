// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

#include "lucarium/scene/scene.h"

namespace lucarium {

struct ImportOptions {
  int gltf_scene = none;                           ///< none: the file's default, else the first
  uint32_t max_texture_size = 8192;                ///< larger images are halved until they fit, with a warning
  uint64_t max_image_pixels = 1u << 28;            ///< larger ones are refused before decoding
  uint64_t max_texture_bytes = uint64_t{8} << 30;  ///< all images, scaled down; half of the free memory if that is less
  uint64_t max_triangles = 200'000'000;
};

}  // namespace lucarium
