// SPDX-License-Identifier: Apache-2.0
// Images to and from files through OpenImageIO, where its own functions are not safe enough.
#pragma once
#include <OpenImageIO/imageio.h>

#include <filesystem>
#include <functional>

namespace lucarium {

/// Reads an open image in bands of rows, from the top: visit(rows, values) gets the channels
/// [first_channel, end_channel) of each pixel, interleaved, as `type`. A band takes about 16 MiB, so that an image can
/// be reduced while it is read. Files may have any attributes; ImageInput::read_image() of version 2.4 divides by
/// tiff:RowsPerStrip. Returns false where the image cannot be decoded; input.geterror() says why.
bool read_rows(OIIO::ImageInput& input, int first_channel, int end_channel, const OIIO::TypeDesc& type,
               const std::function<void(size_t rows, const void* values)>& visit);

/// Writes an image in the format that the name's ending says. Atomic, and every write is checked: OpenImageIO 2.4 takes
/// no notice of what fails when it closes a file. Throws Error{input} with path and reason.
void write_image_file(const std::filesystem::path& file, const OIIO::ImageSpec& spec, const OIIO::TypeDesc& type,
                      const void* pixels);

}  // namespace lucarium
