// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/image/image_decode.h"

#include <OpenImageIO/filesystem.h>

#include <algorithm>
#include <optional>

#include "lucarium/base/error.h"
#include "lucarium/film/image_stream.h"

namespace lucarium {

namespace {

struct Kind {
  const char* reader;  ///< of OpenImageIO; null: not supported
  const char* name;
  std::vector<uint8_t> (*strip)(std::span<const uint8_t>) = nullptr;
  std::string (*damage)(std::span<const uint8_t>) = nullptr;
  std::optional<ImageSize> (*size)(std::span<const uint8_t>) = nullptr;
};

Kind sniff(std::span<const uint8_t> bytes) {
  const auto starts = [&](std::string_view magic, size_t offset = 0) {
    return bytes.size() >= offset + magic.size() &&
           std::equal(magic.begin(), magic.end(), bytes.begin() + offset,
                      [](char a, uint8_t b) { return static_cast<uint8_t>(a) == b; });
  };
  if (starts("\x89PNG\r\n\x1A\n")) return {"png", "PNG", strip_png_metadata, png_damage, png_size};
  if (starts("\xFF\xD8\xFF")) return {"jpeg", "JPEG", strip_jpeg_metadata, jpeg_damage, jpeg_size};
  if (starts("RIFF") && starts("WEBP", 8)) return {nullptr, "a WebP image"};
  if (starts("\xABKTX 20\xBB")) return {nullptr, "a KTX2 image"};
  if (starts("DDS ")) return {nullptr, "a DDS image"};
  if (starts("GIF8")) return {nullptr, "a GIF image"};
  if (starts("BM")) return {nullptr, "a BMP image"};
  return {nullptr, "of an unknown format"};
}

ImageSize halved(ImageSize size) { return {std::max(1u, size.width / 2), std::max(1u, size.height / 2)}; }

/// Times that an image is halved to fit the limit.
uint32_t count_halvings(ImageSize size, uint32_t limit) {
  uint32_t times = 0;
  for (; std::max(size.width, size.height) > limit; size = halved(size)) ++times;
  return times;
}

/// Halves an RGBA image some times while its rows come from the top, so that it is never whole in memory. A pixel is
/// the mean of 2×2; an odd last row or column is left out unless it is the only one.
class RowHalver {
 public:
  RowHalver(ImageSize size, uint32_t times) {
    for (; times > 0; --times, size = halved(size)) levels_.push_back({size, {}, 0});
    result_.width = size.width, result_.height = size.height;
    result_.rgba.reserve(4 * size.pixels());
  }

  void add(std::span<const uint8_t> row) { add(row, 0); }
  Image take() { return std::move(result_); }

 private:
  struct Level {
    ImageSize size;
    std::vector<uint8_t> upper;  ///< the first row of a pair
    uint32_t rows = 0;           ///< so far
  };

  void add(std::span<const uint8_t> row, size_t index) {
    if (index == levels_.size()) {
      result_.rgba.insert(result_.rgba.end(), row.begin(), row.end());
      return;
    }
    Level& level = levels_[index];
    if (level.rows++ % 2 == 0) level.upper.assign(row.begin(), row.end());
    if (level.rows % 2 == 0 || level.size.height == 1) add(mean_row(level, row), index + 1);
  }

  static std::vector<uint8_t> mean_row(const Level& level, std::span<const uint8_t> lower) {
    std::vector<uint8_t> mean(4 * size_t{halved(level.size).width});
    for (size_t i = 0; i < mean.size(); ++i) {
      const size_t left = i / 4 * 8 + i % 4, right = level.size.width == 1 ? left : left + 4;
      const uint32_t sum = 2u + level.upper[left] + level.upper[right] + lower[left] + lower[right];
      mean[i] = static_cast<uint8_t>(sum / 4);
    }
    return mean;
  }

  std::vector<Level> levels_;
  Image result_;
};

/// Moves the channels of each pixel (1 grey, 2 grey and alpha, 3 colour, 4 colour and alpha) to RGBA.
void to_rgba(const uint8_t* in, size_t channels, std::span<uint8_t> out) {
  for (size_t i = 0; i < out.size(); i += 4, in += channels) {
    for (size_t c = 0; c < 3; ++c) out[i + c] = in[channels < 3 ? 0 : c];
    out[i + 3] = channels == 2 ? in[1] : channels >= 4 ? in[3] : uint8_t(255);
  }
}

[[noreturn]] void fail_damaged(const Kind& kind, const std::string& what, const std::string& reason) {
  throw_error(ErrorClass::input, "{} is a damaged {}: {}", what, kind.name,
              reason.empty() ? "it cannot be decoded" : reason);
}

Kind readable_kind(std::span<const uint8_t> encoded, const std::string& what) {
  const Kind kind = sniff(encoded);
  if (!kind.reader) throw_error(ErrorClass::input, "{} is {}; only PNG and JPEG can be read", what, kind.name);
  return kind;
}

/// The size that the header states; throws where it is not to be decoded.
ImageSize checked_size(const Kind& kind, std::span<const uint8_t> encoded, const std::string& what,
                       const ImportOptions& options) {
  const std::optional<ImageSize> size = kind.size(encoded);
  if (!size) fail_damaged(kind, what, "it is cut off");
  if (size->pixels() == 0) fail_damaged(kind, what, "it has no pixels");
  if (size->pixels() > options.max_image_pixels) {
    throw_error(ErrorClass::input, "{} has {}x{} pixels, more than the {} that are allowed; scale it down", what,
                size->width, size->height, options.max_image_pixels);
  }
  return *size;
}

}  // namespace

ImageSize decoded_size(std::span<const uint8_t> encoded, const std::string& what, const ImportOptions& options) {
  ImageSize size = checked_size(readable_kind(encoded, what), encoded, what, options);
  for (uint32_t times = count_halvings(size, options.max_texture_size); times > 0; --times) size = halved(size);
  return size;
}

DecodedImage decode_image(std::span<const uint8_t> encoded, const std::string& what, const ImportOptions& options) {
  const Kind kind = readable_kind(encoded, what);
  const auto fail = [&](const std::string& reason) { fail_damaged(kind, what, reason); };
  if (const std::string damage = kind.damage(encoded); !damage.empty()) fail(damage);
  const ImageSize size = checked_size(kind, encoded, what, options);
  const std::vector<uint8_t> bare = kind.strip(encoded);
  OIIO::Filesystem::IOMemReader memory(bare.data(), bare.size());
  OIIO::ImageSpec config;
  config["oiio:UnassociatedAlpha"] = 1;
  const auto input = OIIO::ImageInput::create(kind.reader);
  if (!input || !input->set_ioproxy(&memory)) fail(OIIO::geterror());
  OIIO::ImageSpec spec;
  if (!input->open("image", spec, config)) fail(input->geterror());
  if (spec.width != static_cast<int>(size.width) || spec.height != static_cast<int>(size.height) ||
      spec.nchannels <= 0) {
    fail("its header contradicts itself");
  }
  const size_t channels = static_cast<size_t>(std::min(spec.nchannels, 4)), width = size.width;
  const uint32_t times = count_halvings(size, options.max_texture_size);
  RowHalver halver(size, times);
  std::vector<uint8_t> rgba(4 * width);
  const auto add_rows = [&](size_t rows, const void* values) {
    for (size_t row = 0; row < rows; ++row) {
      to_rgba(static_cast<const uint8_t*>(values) + row * width * channels, channels, rgba);
      halver.add(rgba);
    }
  };
  if (!read_rows(*input, 0, static_cast<int>(channels), OIIO::TypeDesc::UINT8, add_rows)) fail(input->geterror());
  input->close();
  return {halver.take(), times > 0};
}

}  // namespace lucarium
