// SPDX-License-Identifier: Apache-2.0
#include "lucarium/view/picture_code.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"

namespace lucarium {

namespace {

constexpr uint32_t length_bytes = 4;
constexpr int largest_exponent = 14;  // of a half float that leaves room for rounding

/// The power of two that brings the largest finite value to [2^14, 2^15).
int choose_exponent(const std::vector<float>& rgb) {
  float largest = 0;
  for (const float value : rgb) {
    const float magnitude = std::abs(value);
    if (magnitude > largest && magnitude < INFINITY) largest = magnitude;
  }
  return largest > 0 ? std::ilogb(largest) - largest_exponent : 0;
}

std::string deflate_quickly(const std::string& bytes) {
  z_stream stream{};
  // Level 1: of noisy halves the other levels save a few hundredths, in several times the time.
  if (deflateInit(&stream, 1) != Z_OK) throw_error(ErrorClass::internal, "zlib cannot be initialized");
  std::string packed(deflateBound(&stream, static_cast<uLong>(bytes.size())), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  const int status = deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  if (status != Z_STREAM_END) throw_error(ErrorClass::internal, "zlib cannot compress {} bytes", bytes.size());
  return packed;
}

std::string with_header(const nlohmann::ordered_json& header, const std::string& rest) {
  const std::string text = header.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  std::string length(length_bytes, '\0');
  for (uint32_t i = 0; i < length_bytes; ++i) length[i] = static_cast<char>(text.size() >> (8 * i) & 0xff);
  return length + text + rest;
}

}  // namespace

uint16_t half_bits(float value) {
  const uint32_t bits = std::bit_cast<uint32_t>(value);
  const uint32_t sign = bits >> 16 & 0x8000u, magnitude = bits & 0x7fffffffu;
  if (magnitude >= 0x7f800000u) return static_cast<uint16_t>(sign | (magnitude > 0x7f800000u ? 0x7e00u : 0x7c00u));
  if (magnitude >= 0x477ff000u) return static_cast<uint16_t>(sign | 0x7c00u);  // rounds to 65536
  if (magnitude < 0x38800000u) {                                               // below 2^-14: steps of 2^-24
    // Adding 2^-1 to a value below it leaves steps of 2^-24 in the mantissa, rounded as the processor rounds.
    const float shifted = std::bit_cast<float>(magnitude) + 0.5f;
    return static_cast<uint16_t>(sign | (std::bit_cast<uint32_t>(shifted) - 0x3f000000u));
  }
  const uint32_t rounded = magnitude - (112u << 23) + 0xfffu + (magnitude >> 13 & 1u);
  return static_cast<uint16_t>(sign | rounded >> 13);
}

float half_value(uint16_t bits) {
  const int exponent = bits >> 10 & 31, mantissa = bits & 1023;
  float magnitude =
      std::ldexp(static_cast<float>(exponent > 0 ? mantissa + 1024 : mantissa), std::max(exponent, 1) - 25);
  if (exponent == 31) magnitude = mantissa != 0 ? NAN : INFINITY;
  return (bits & 0x8000) != 0 ? -magnitude : magnitude;
}

std::string encode_view_picture(nlohmann::ordered_json header, uint32_t width, uint32_t height,
                                const std::vector<float>& rgb) {
  const int exponent = choose_exponent(rgb);
  header["width"] = width;
  header["height"] = height;
  header["exponent"] = exponent;
  const size_t pixels = size_t{width} * height, values = 3 * pixels;
  const float scale = std::ldexp(1.0f, -exponent);
  // Of a picture whose largest value is tiny the scale itself is no float: two factors are.
  const float first = std::isinf(scale) ? std::ldexp(1.0f, -exponent / 2) : scale;
  const float second = std::isinf(scale) ? std::ldexp(1.0f, -exponent + exponent / 2) : 1.0f;
  std::string planes(2 * values, '\0');
  for (size_t c = 0; c < 3; ++c) {
    char* const high = planes.data() + c * pixels;
    char* const low = high + values;
    for (size_t i = 0; i < pixels; ++i) {
      const uint16_t bits = half_bits(rgb[3 * i + c] * first * second);
      high[i] = static_cast<char>(bits >> 8);
      low[i] = static_cast<char>(bits & 0xff);
    }
  }
  return with_header(header, deflate_quickly(planes));
}

std::string encode_view_file(const std::string& name, const std::string& bytes) {
  return with_header({{"file", name}}, bytes);
}

ViewPicture decode_view_picture(std::string_view data) {
  const auto fail = [] { throw_error(ErrorClass::input, "a picture of the viewer is damaged"); };
  size_t length = 0;
  if (data.size() < length_bytes) fail();
  for (uint32_t i = 0; i < length_bytes; ++i) length |= size_t{static_cast<uint8_t>(data[i])} << (8 * i);
  if (data.size() - length_bytes < length) fail();
  ViewPicture picture;
  picture.header = data.substr(length_bytes, length);
  const nlohmann::json header = nlohmann::json::parse(picture.header, nullptr, false);
  if (!header.is_object()) fail();
  picture.width = header.value("width", 0u);
  picture.height = header.value("height", 0u);
  const int exponent = header.value("exponent", 0);
  const size_t pixels = size_t{picture.width} * picture.height, values = 3 * pixels;
  std::string planes(2 * values, '\0');
  auto size = static_cast<uLongf>(planes.size());
  const std::string_view packed = data.substr(length_bytes + length);
  if (uncompress(reinterpret_cast<Bytef*>(planes.data()), &size, reinterpret_cast<const Bytef*>(packed.data()),
                 static_cast<uLong>(packed.size())) != Z_OK ||
      size != planes.size())
    fail();
  picture.rgb.resize(values);
  for (size_t i = 0; i < values; ++i) {
    const size_t plane = i % 3 * pixels + i / 3;
    const auto high = static_cast<uint8_t>(planes[plane]), low = static_cast<uint8_t>(planes[values + plane]);
    picture.rgb[i] = std::ldexp(half_value(static_cast<uint16_t>(high << 8 | low)), exponent);
  }
  return picture;
}

}  // namespace lucarium
