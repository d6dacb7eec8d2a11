// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

namespace lucarium {

// The most that command lines, comparison files and job files may ask for.
inline constexpr uint32_t largest_image_side = 32768;    ///< [pixels]
inline constexpr uint32_t finest_pixel_grid = 16;        ///< n of n×n points in a pixel
inline constexpr uint32_t largest_texture_size = 65536;  ///< to which textures are halved [pixels]
inline constexpr int max_threads = 4096;                 ///< of a CPU device

}  // namespace lucarium
