// SPDX-License-Identifier: Apache-2.0
// Environment maps: .hdr and .exr through OpenImageIO.
#include "lucarium/scene/image/environment_file.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/log.h"
#include "lucarium/film/image_stream.h"
#include "lucarium/scene/import_options.h"

namespace lucarium {

namespace {

enum class MapFormat { unknown, hdr, exr };

MapFormat sniff_map(const std::filesystem::path& file) {
  char start[10] = {};
  std::ifstream stream(file, std::ios::binary);
  stream.read(start, sizeof(start));
  const std::string_view text(start, sizeof(start));
  if (text.starts_with("#?RADIANCE") || text.starts_with("#?RGBE")) return MapFormat::hdr;
  return text.starts_with("\x76\x2F\x31\x01") ? MapFormat::exr : MapFormat::unknown;
}

void check_size(const OIIO::ImageSpec& spec, const std::string& name, const ImportOptions& options) {
  if (spec.width <= 0 || spec.height <= 0) throw_error(ErrorClass::input, "{}: it has no pixels", name);
  if (spec.depth > 1 || spec.deep)
    throw_error(ErrorClass::input, "{}: deep and volume images are not environment maps", name);
  const uint64_t pixels = static_cast<uint64_t>(spec.width) * static_cast<uint64_t>(spec.height);
  const uint64_t tile =
      static_cast<uint64_t>(std::max(spec.tile_width, 1)) * static_cast<uint64_t>(std::max(spec.tile_height, 1));
  if (std::max(pixels, tile) > options.max_image_pixels) {
    throw_error(ErrorClass::input, "{}: {}x{} pixels are more than the {} that are allowed; scale it down", name,
                spec.width, spec.height, options.max_image_pixels);
  }
  if (spec.nchannels > 64) throw_error(ErrorClass::input, "{}: {} channels are too many", name, spec.nchannels);
}

/// The positions of R, G and B; of a single channel three times.
glm::ivec3 color_channels(const OIIO::ImageSpec& spec) {
  glm::ivec3 channels = spec.nchannels >= 3 ? glm::ivec3(0, 1, 2) : glm::ivec3(0);
  const char* names[] = {"R", "G", "B"};
  glm::ivec3 named;
  for (int c = 0; c < 3; ++c) named[c] = spec.channelindex(names[c]);
  return glm::all(glm::greaterThanEqual(named, glm::ivec3(0))) ? named : channels;
}

}  // namespace

Environment load_environment(const std::filesystem::path& file, const ImportOptions& options) {
  const std::string name = file.string();
  require_regular_file(file);
  const MapFormat kind = sniff_map(file);
  if (kind == MapFormat::unknown) {
    throw_error(ErrorClass::input, "{}: this is neither a Radiance .hdr nor an OpenEXR .exr file", name);
  }
  const auto damaged = [&](std::string reason) {
    for (char& c : reason) c = c == '\n' ? ' ' : c;
    throw_error(ErrorClass::input, "{}: the {} file is damaged: {}", name,
                kind == MapFormat::hdr ? "Radiance" : "OpenEXR", reason.empty() ? "it cannot be decoded" : reason);
  };
  // The reader is chosen by the contents: the name may have any ending.
  const auto input = OIIO::ImageInput::create(kind == MapFormat::hdr ? "hdr" : "openexr");
  OIIO::ImageSpec spec;
  if (!input) damaged(OIIO::geterror());
  if (!input->open(name, spec)) damaged(input->geterror());
  check_size(spec, name, options);
  const size_t count = static_cast<size_t>(spec.width) * static_cast<size_t>(spec.height);
  Environment environment;
  environment.name = file.filename().string();
  environment.width = static_cast<uint32_t>(spec.width);
  environment.height = static_cast<uint32_t>(spec.height);
  environment.radiance.reserve(count);  // filled as the rows come: what is cut off takes no memory
  const glm::ivec3 rgb = color_channels(spec);
  const int first = std::min({rgb.r, rgb.g, rgb.b}), end = std::max({rgb.r, rgb.g, rgb.b}) + 1;
  size_t negative = 0, not_finite = 0;
  const auto add_rows = [&](size_t rows, const void* values) {
    const float* pixel = static_cast<const float*>(values);
    for (size_t i = 0; i < rows * environment.width; ++i, pixel += end - first) {
      glm::vec3& radiance = environment.radiance.emplace_back();
      for (int c = 0; c < 3; ++c) {
        const float value = pixel[rgb[c] - first];
        not_finite += !std::isfinite(value);
        negative += value < 0;
        radiance[c] = std::max(value, 0.f);
      }
    }
  };
  if (!read_rows(*input, first, end, OIIO::TypeFloat, add_rows)) damaged(input->geterror());
  input->close();
  if (not_finite) {
    throw_error(ErrorClass::input, "{}: {} values are infinite or not numbers; clamp them in an image editor", name,
                not_finite);
  }
  if (negative) log_warning("{}: {} negative values were taken as 0", name, negative);
  return environment;
}

}  // namespace lucarium
