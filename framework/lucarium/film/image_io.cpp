// SPDX-License-Identifier: Apache-2.0
#include "lucarium/film/image_io.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <optional>
#include <set>
#include <span>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/log.h"
#include "lucarium/base/srgb.h"
#include "lucarium/film/encoded_image.h"
#include "lucarium/film/image_stream.h"

namespace lucarium {
namespace fs = std::filesystem;
namespace {

constexpr float largest_half = 65504.f;
constexpr uint64_t max_values = uint64_t{1} << 31;  // of all channels; larger files are refused before memory is taken
constexpr std::string_view attribute_prefix = "lucarium:";
const std::string additive_attribute = "lucarium:additive_layers";

/// Channel name of a layer in an EXR: "direct.R".
std::string channel_name(const FilmLayer& layer, size_t channel) { return layer.name + "." + layer.channels[channel]; }

OIIO::ImageSpec exr_spec(const Film& film, const ExrOptions& options) {
  std::vector<std::string> names = {"R", "G", "B"};
  std::set<std::string>
      additive;  // sorted, so that a film that was read and extended says the same as one made at once
  for (const FilmLayer& layer : film.layers()) {
    for (size_t c = 0; c < layer.channels.size(); ++c) names.push_back(channel_name(layer, c));
    if (layer.additive) additive.insert(layer.name);
  }
  OIIO::ImageSpec spec(static_cast<int>(film.width()), static_cast<int>(film.height()), static_cast<int>(names.size()),
                       options.half ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT);
  spec.channelnames = names;
  spec.attribute("compression", "zip");
  spec.attribute("oiio:ColorSpace", "Linear");
  spec.attribute(additive_attribute, fmt::format("{}", fmt::join(additive, ",")));
  for (const auto& [key, value] : film.metadata) spec.attribute(std::string(attribute_prefix) + key, value);
  return spec;
}

std::vector<float> interleave(const Film& film, size_t channels) {
  std::vector<float> pixels(film.pixel_count() * channels);
  const std::vector<float> image = film.image();
  for (size_t p = 0; p < film.pixel_count(); ++p) std::copy_n(&image[3 * p], 3, &pixels[channels * p]);
  size_t first = 3;
  for (const FilmLayer& layer : film.layers()) {
    const size_t count = layer.channels.size();
    for (size_t p = 0; p < film.pixel_count(); ++p)
      std::copy_n(&layer.pixels[count * p], count, &pixels[channels * p + first]);
    first += count;
  }
  return pixels;
}

uint8_t srgb_byte(float linear) {
  return static_cast<uint8_t>(std::lround(255 * srgb_from_linear(std::clamp(double{linear}, 0.0, 1.0))));
}

std::vector<uint8_t> tone_map(const std::vector<float>& rgb, float exposure_stops) {
  const float scale = std::exp2(exposure_stops);
  std::vector<uint8_t> bytes(rgb.size());
  std::transform(rgb.begin(), rgb.end(), bytes.begin(),
                 [scale](float v) { return srgb_byte(std::isnan(v) ? 0.f : v * scale); });
  return bytes;
}

OIIO::ImageSpec png_spec(uint32_t width, uint32_t height) {
  OIIO::ImageSpec spec(static_cast<int>(width), static_cast<int>(height), 3, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  return spec;
}

/// Splits "direct.R" into layer and channel; a bare "R" has an empty layer.
std::pair<std::string, std::string> split_channel(const std::string& name) {
  const size_t dot = name.rfind('.');
  if (dot == std::string::npos) return {"", name};
  return {name.substr(0, dot), name.substr(dot + 1)};
}

bool is_additive(const std::string& list, const std::string& layer) {
  return ("," + list + ",").find("," + layer + ",") != std::string::npos;
}

/// Makes all channels but alpha linear.
void decode_srgb(const OIIO::ImageSpec& spec, std::vector<float>& pixels) {
  for (size_t i = 0; i < pixels.size(); ++i) {
    if (static_cast<int>(i % static_cast<size_t>(spec.nchannels)) == spec.alpha_channel) continue;
    pixels[i] = static_cast<float>(linear_from_srgb(pixels[i]));
  }
}

/// Distributes interleaved channels onto layers. Without named layers the first three channels are the image.
void fill_layers(Film& film, const OIIO::ImageSpec& spec, const std::vector<float>& pixels) {
  const size_t channels = static_cast<size_t>(spec.nchannels);
  const std::string additive = spec.get_string_attribute(additive_attribute);
  std::map<std::string, std::vector<size_t>> members;
  std::vector<std::string> order;
  for (size_t c = 0; c < channels; ++c) {
    const std::string layer = split_channel(spec.channelnames[c]).first;
    if (layer.empty()) continue;
    if (!members.count(layer)) order.push_back(layer);
    members[layer].push_back(c);
  }
  if (additive.empty()) {
    FilmLayer& image = film.layer("image", {"R", "G", "B"}, true);
    for (size_t p = 0; p < film.pixel_count(); ++p) {
      for (size_t c = 0; c < 3; ++c) image.pixels[3 * p + c] = pixels[channels * p + (channels >= 3 ? c : 0)];
    }
  }
  for (const std::string& name : order) {
    std::vector<std::string> names;
    for (const size_t c : members[name]) names.push_back(split_channel(spec.channelnames[c]).second);
    FilmLayer& layer = film.layer(name, names, is_additive(additive, name));
    for (size_t p = 0; p < film.pixel_count(); ++p) {
      for (size_t i = 0; i < names.size(); ++i)
        layer.pixels[names.size() * p + i] = pixels[channels * p + members[name][i]];
    }
  }
}

void check_size(const fs::path& file, int64_t width, int64_t height, int64_t channels) {
  // Each is an int, so that only the product of all three could overflow.
  if (width > 0 && height > 0 && channels > 0 &&
      static_cast<uint64_t>(width) * static_cast<uint64_t>(height) <= max_values / static_cast<uint64_t>(channels)) {
    return;
  }
  throw_error(ErrorClass::input, "{}: {}×{} pixels with {} channels is not an image this program reads", file.string(),
              width, height, channels);
}

/// What must be known before OpenImageIO opens a file: opening a JPEG can take as much memory as decoding it, and of a
/// damaged PNG libpng prints lines of its own to standard error.
void check_encoded(const fs::path& file) {
  char start[3] = {};
  std::ifstream(file, std::ios::binary).read(start, sizeof start);
  const bool is_png = std::string_view(start, sizeof start) == "\x89PN";
  if (!is_png && std::string_view(start, sizeof start) != "\xFF\xD8\xFF") return;
  const std::string bytes = read_file(file);
  const std::span<const uint8_t> encoded(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
  const std::string damage = is_png ? png_damage(encoded) : jpeg_damage(encoded);
  if (!damage.empty()) throw_error(ErrorClass::input, "{}: damaged image: {}", file.string(), damage);
  if (is_png) return;
  const std::optional<ImageSize> size = jpeg_size(encoded);
  check_size(file, size->width, size->height, 3);
}

}  // namespace

void write_exr(const fs::path& file, const Film& film, const ExrOptions& options) {
  const OIIO::ImageSpec spec = exr_spec(film, options);
  const std::vector<float> pixels = interleave(film, static_cast<size_t>(spec.nchannels));
  if (options.half) {
    const auto overflows =
        std::count_if(pixels.begin(), pixels.end(), [](float v) { return std::abs(v) > largest_half; });
    if (overflows)
      log_warning("{}: {} values do not fit into half floats; write without --half", file.string(), overflows);
  }
  write_image_file(file, spec, OIIO::TypeDesc::FLOAT, pixels.data());
}

void write_png(const fs::path& file, uint32_t width, uint32_t height, const std::vector<float>& rgb,
               float exposure_stops) {
  write_image_file(file, png_spec(width, height), OIIO::TypeDesc::UINT8, tone_map(rgb, exposure_stops).data());
}

void write_png(const fs::path& file, const Film& film, float exposure_stops) {
  write_png(file, film.width(), film.height(), film.image(), exposure_stops);
}

std::string encode_png(uint32_t width, uint32_t height, const std::vector<float>& rgb, float exposure_stops) {
  std::vector<unsigned char> encoded;
  OIIO::Filesystem::IOVecOutput memory(encoded);
  const std::unique_ptr<OIIO::ImageOutput> out = OIIO::ImageOutput::create("png");
  const std::vector<uint8_t> bytes = tone_map(rgb, exposure_stops);
  if (!out || !out->set_ioproxy(&memory) || !out->open("memory.png", png_spec(width, height)) ||
      !out->write_image(OIIO::TypeDesc::UINT8, bytes.data()) || !out->close()) {
    throw_error(ErrorClass::internal, "cannot encode a PNG: {}", out ? out->geterror() : OIIO::geterror());
  }
  return {encoded.begin(), encoded.end()};
}

namespace {

Film read(const fs::path& file, bool is_reference) {
  require_regular_file(file);
  check_encoded(file);
  const std::unique_ptr<OIIO::ImageInput> in = OIIO::ImageInput::open(file.string());
  if (!in) throw_error(ErrorClass::input, "{}: not a readable image: {}", file.string(), OIIO::geterror());
  const OIIO::ImageSpec spec = in->spec();
  if (spec.deep || spec.depth > 1)
    throw_error(ErrorClass::input, "{}: deep and volume images are not read", file.string());
  check_size(file, spec.width, spec.height, spec.nchannels);
  const size_t row_values = static_cast<size_t>(spec.width) * static_cast<size_t>(spec.nchannels);
  std::vector<float> pixels;
  pixels.reserve(row_values * static_cast<size_t>(spec.height));
  const auto add_rows = [&](size_t rows, const void* values) {
    const float* first = static_cast<const float*>(values);
    pixels.insert(pixels.end(), first, first + rows * row_values);
  };
  if (!read_rows(*in, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, add_rows)) {
    throw_error(ErrorClass::input, "{}: damaged image: {}", file.string(), in->geterror());
  }
  if (is_reference && !spec.format.is_floating_point())
    log_warning("{}: {}-bit picture as a reference: values above 1 are lost; give an .exr", file.string(),
                8 * spec.format.size());
  if (spec.get_string_attribute("oiio:ColorSpace") == "sRGB") decode_srgb(spec, pixels);
  Film film(static_cast<uint32_t>(spec.width), static_cast<uint32_t>(spec.height));
  fill_layers(film, spec, pixels);
  for (const OIIO::ParamValue& attribute : spec.extra_attribs) {
    const std::string name = attribute.name().string();
    if (name.starts_with(attribute_prefix) && name != additive_attribute) {
      film.metadata[name.substr(attribute_prefix.size())] = attribute.get_string();
    }
  }
  log_info("read {}: {}×{} pixels, {} layers", file.string(), film.width(), film.height(), film.layers().size());
  return film;
}

}  // namespace

Film read_image(const fs::path& file) { return read(file, false); }
Film read_reference_image(const fs::path& file) { return read(file, true); }

}  // namespace lucarium
