// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace lucarium {

/// Copies of encoded images without metadata: colour profiles, gamma, EXIF, XMP, text. glTF demands that they are
/// ignored, and their parsers are what hostile images aim at (deeply nested XMP overflows OpenImageIO's stack).
/// Damaged files come out damaged; the decoder complains.
std::vector<uint8_t> strip_png_metadata(std::span<const uint8_t> png);
std::vector<uint8_t> strip_jpeg_metadata(std::span<const uint8_t> jpeg);

/// What is wrong with the chunks of a PNG (lengths, checksums); empty where nothing is. libpng finds it too, but
/// prints to standard error.
std::string png_damage(std::span<const uint8_t> png);

}  // namespace lucarium
