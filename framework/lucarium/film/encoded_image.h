// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace lucarium {

/// Copies of encoded images without metadata: colour profiles, gamma, EXIF, XMP, text. glTF demands that they are
/// ignored, and hostile images aim at their parsers (deeply nested XMP overflows OpenImageIO's stack).
/// Damaged files come out damaged; the decoder complains.
std::vector<uint8_t> strip_png_metadata(std::span<const uint8_t> png);
std::vector<uint8_t> strip_jpeg_metadata(std::span<const uint8_t> jpeg);

/// First fault in the chunks of a PNG (lengths, checksums); empty if there is none. libpng finds faults too, but
/// prints them to standard error.
std::string png_damage(std::span<const uint8_t> png);
/// Fault in the header of a JPEG, or too little data for its size: libjpeg would allocate memory for the whole picture
/// before it finds that nearly all of it is missing.
std::string jpeg_damage(std::span<const uint8_t> jpeg);

struct ImageSize {
  uint32_t width = 0, height = 0;  // pixels
  uint64_t pixels() const { return uint64_t{width} * height; }
};

/// Size in the header, read without a decoder: opening a progressive JPEG decodes all of it. Empty where there is
/// none.
std::optional<ImageSize> png_size(std::span<const uint8_t> png);
std::optional<ImageSize> jpeg_size(std::span<const uint8_t> jpeg);

}  // namespace lucarium
