// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <string>

#include "lucarium/film/encoded_image.h"
#include "lucarium/scene/import_options.h"

namespace lucarium {

struct DecodedImage {
  Image image;
  bool shrunk = false;  ///< halved to fit the limit
};

/// Decodes a PNG or JPEG to RGBA8 (grey, palette, 1, 2, 4 and 16 bits and CMYK are converted, alpha stays
/// unassociated) and halves it, while it is decoded, until it fits options.max_texture_size. The format is found
/// from the contents. Images of more than options.max_image_pixels are refused before any pixel is decoded. Colour
/// profiles and other metadata are ignored, as glTF demands. Throws Error{input} that starts with `what`.
DecodedImage decode_image(std::span<const uint8_t> encoded, const std::string& what, const ImportOptions& options);

/// The size that decode_image() would give, from the header alone. Throws Error{input} where
/// the kind is not supported or the size is not allowed.
ImageSize decoded_size(std::span<const uint8_t> encoded, const std::string& what, const ImportOptions& options);

}  // namespace lucarium
