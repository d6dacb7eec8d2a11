// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/image/image_decode.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/scene/image/encoded_image.h"
#include "lucarium/scene/import_options.h"

namespace lucarium {

namespace {

struct Kind {
  const char* reader;  ///< of OpenImageIO; null: not supported
  const char* name;
  std::vector<uint8_t> (*strip)(std::span<const uint8_t>) = nullptr;
  std::string (*damage)(std::span<const uint8_t>) = nullptr;
};

Kind sniff(std::span<const uint8_t> bytes) {
  const auto starts = [&](std::string_view magic, size_t offset = 0) {
    return bytes.size() >= offset + magic.size() &&
           std::equal(magic.begin(), magic.end(), bytes.begin() + offset,
                      [](char a, uint8_t b) { return static_cast<uint8_t>(a) == b; });
  };
  if (starts("\x89PNG\r\n\x1A\n")) return {"png", "PNG", strip_png_metadata, png_damage};
  if (starts("\xFF\xD8\xFF")) return {"jpeg", "JPEG", strip_jpeg_metadata};
  if (starts("RIFF") && starts("WEBP", 8)) return {nullptr, "a WebP image"};
  if (starts("\xABKTX 20\xBB")) return {nullptr, "a KTX2 image"};
  if (starts("DDS ")) return {nullptr, "a DDS image"};
  if (starts("GIF8")) return {nullptr, "a GIF image"};
  if (starts("BM")) return {nullptr, "a BMP image"};
  return {nullptr, "not an image known here"};
}

/// Means of 2×2 pixels; odd last rows and columns are merged into their neighbours' by clamping.
void halve(Image& image) {
  const uint32_t width = std::max(1u, image.width / 2), height = std::max(1u, image.height / 2);
  std::vector<uint8_t> rgba(static_cast<size_t>(width) * height * 4);
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      for (uint32_t c = 0; c < 4; ++c) {
        uint32_t sum = 2;
        for (uint32_t dy = 0; dy < 2; ++dy) {
          for (uint32_t dx = 0; dx < 2; ++dx) {
            const size_t row = std::min(2 * y + dy, image.height - 1), column = std::min(2 * x + dx, image.width - 1);
            sum += image.rgba[4 * (row * image.width + column) + c];
          }
        }
        rgba[4 * (static_cast<size_t>(y) * width + x) + c] = static_cast<uint8_t>(sum / 4);
      }
    }
  }
  image.width = width, image.height = height, image.rgba = std::move(rgba);
}

/// Moves the channels of each pixel (1 grey, 2 grey and alpha, 3 colour, 4 colour and alpha) to RGBA.
std::vector<uint8_t> to_rgba(const std::vector<uint8_t>& pixels, int channels) {
  const size_t count = pixels.size() / static_cast<size_t>(channels);
  std::vector<uint8_t> rgba(4 * count);
  for (size_t i = 0; i < count; ++i) {
    const uint8_t* in = pixels.data() + i * static_cast<size_t>(channels);
    uint8_t* out = rgba.data() + 4 * i;
    for (int c = 0; c < 3; ++c) out[c] = in[channels < 3 ? 0 : c];
    out[3] = channels == 2 ? in[1] : channels >= 4 ? in[3] : uint8_t(255);
  }
  return rgba;
}

}  // namespace

DecodedImage decode_image(std::span<const uint8_t> encoded, const std::string& what, const ImportOptions& options) {
  const Kind kind = sniff(encoded);
  if (!kind.reader) throw_error(ErrorClass::input, "{} is {}; only PNG and JPEG can be read", what, kind.name);
  const auto fail = [&](const std::string& reason) {
    throw_error(ErrorClass::input, "{} is a damaged {}: {}", what, kind.name,
                reason.empty() ? "it cannot be decoded" : reason);
  };
  if (kind.damage) {
    if (const std::string damage = kind.damage(encoded); !damage.empty()) fail(damage);
  }
  const std::vector<uint8_t> bare = kind.strip(encoded);
  OIIO::Filesystem::IOMemReader memory(bare.data(), bare.size());
  OIIO::ImageSpec config;
  config["oiio:UnassociatedAlpha"] = 1;
  const auto input = OIIO::ImageInput::create(kind.reader);
  if (!input || !input->set_ioproxy(&memory)) fail(OIIO::geterror());
  OIIO::ImageSpec spec;
  if (!input->open("image", spec, config)) fail(input->geterror());
  if (spec.width <= 0 || spec.height <= 0 || spec.nchannels <= 0) fail("it has no pixels");
  const uint64_t count = static_cast<uint64_t>(spec.width) * static_cast<uint64_t>(spec.height);
  if (count > options.max_image_pixels) {
    throw_error(ErrorClass::input, "{} has {}x{} pixels, more than the {} that are allowed; scale it down", what,
                spec.width, spec.height, options.max_image_pixels);
  }
  const int channels = std::min(spec.nchannels, 4);
  DecodedImage result;
  Image& image = result.image;
  image.width = static_cast<uint32_t>(spec.width), image.height = static_cast<uint32_t>(spec.height);
  std::vector<uint8_t> pixels(count * static_cast<size_t>(channels));
  if (!input->read_image(0, 0, 0, channels, OIIO::TypeDesc::UINT8, pixels.data())) fail(input->geterror());
  input->close();
  image.rgba = channels == 4 ? std::move(pixels) : to_rgba(pixels, channels);
  while (std::max(image.width, image.height) > options.max_texture_size) {
    halve(image);
    result.shrunk = true;
  }
  return result;
}

}  // namespace lucarium
