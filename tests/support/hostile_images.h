// SPDX-License-Identifier: Apache-2.0
// Images whose headers lie, made from good ones.
#pragma once
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <doctest/doctest.h>

#include <string>
#include <vector>

namespace lucarium::test {

/// An encoded image; `format` is OpenImageIO's name ("png", "jpeg", "openexr").
inline std::string encode_image(const char* format, const OIIO::ImageSpec& spec, OIIO::TypeDesc type,
                                const void* pixels) {
  std::vector<unsigned char> encoded;
  OIIO::Filesystem::IOVecOutput memory(encoded);
  const auto out = OIIO::ImageOutput::create(format);
  REQUIRE(out);
  REQUIRE(out->set_ioproxy(&memory));
  REQUIRE(out->open("memory", spec));
  if (spec.tile_width > 0) {
    REQUIRE(out->write_image(type, pixels));
  } else {
    REQUIRE(out->write_scanlines(spec.y, spec.y + spec.height, spec.z, type, pixels));
  }
  REQUIRE(out->close());
  return {encoded.begin(), encoded.end()};
}

/// A grey JPEG of 8×8 pixels whose header states another size. A progressive one is decoded when it is opened.
inline std::string jpeg_that_states(uint32_t width, uint32_t height, bool progressive) {
  OIIO::ImageSpec spec(8, 8, 3, OIIO::TypeDesc::UINT8);
  spec.attribute("jpeg:progressive", progressive ? 1 : 0);
  const std::vector<uint8_t> grey(8 * 8 * 3, 128);
  std::string jpeg = encode_image("jpeg", spec, OIIO::TypeDesc::UINT8, grey.data());
  const size_t frame = jpeg.find(progressive ? "\xFF\xC2" : "\xFF\xC0");
  REQUIRE(frame != std::string::npos);
  const auto put = [&](size_t at, uint32_t value) {
    jpeg[frame + at] = static_cast<char>(value >> 8);
    jpeg[frame + at + 1] = static_cast<char>(value & 255);
  };
  put(5, height);
  put(7, width);
  return jpeg;
}

/// A float EXR of one colour with the attribute by which OpenImageIO 2.4 divides.
inline std::string exr_without_rows_per_strip(uint32_t width, uint32_t height) {
  OIIO::ImageSpec spec(static_cast<int>(width), static_cast<int>(height), 3, OIIO::TypeDesc::FLOAT);
  spec.attribute("tiff:RowsPerStrip", 0);
  const std::vector<float> values(size_t{3} * width * height, 0.5f);
  return encode_image("openexr", spec, OIIO::TypeDesc::FLOAT, values.data());
}

}  // namespace lucarium::test
