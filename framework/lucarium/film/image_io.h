// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "lucarium/film/film.h"

namespace lucarium {

struct ExrOptions {
  bool half = false;  ///< 16-bit; values above 65504 are counted and reported as a warning
};

/// Writes R,G,B (the image) first, then "layer.channel" for every layer, and metadata as "lucarium:key" attributes.
/// Atomic. Throws Error{input}.
void write_exr(const std::filesystem::path& file, const Film& film, const ExrOptions& options = {});

/// 8-bit preview: image · 2^exposure_stops, linear Rec.709 → sRGB, clamped. Atomic.
void write_png(const std::filesystem::path& file, const Film& film, float exposure_stops = 0);
/// The same for a bare RGB float image.
void write_png(const std::filesystem::path& file, uint32_t width, uint32_t height, const std::vector<float>& rgb,
               float exposure_stops = 0);
/// PNG bytes in memory (for reports).
std::string encode_png(uint32_t width, uint32_t height, const std::vector<float>& rgb, float exposure_stops = 0);

/// Reads EXR (layers and metadata restored), HDR, or any image OpenImageIO reads (one additive layer "image"; values
/// that the file says are sRGB, as those of PNG and JPEG files, become linear).
Film read_image(const std::filesystem::path& file);
/// The same of an image that errors are measured against: warns when the file holds whole numbers, which end at 1.
Film read_reference_image(const std::filesystem::path& file);

}  // namespace lucarium
