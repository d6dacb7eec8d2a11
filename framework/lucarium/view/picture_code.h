// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace lucarium {

/// The half float nearest to a value, ties to even; above 65504 infinite.
uint16_t half_bits(float value);
float half_value(uint16_t bits);

/// A picture as the viewer sends it; view/page/connection.js is the reader.
///
///   4 bytes   length of the header, little-endian
///   header    JSON: what the caller says of the picture, and "width", "height", "exponent"
///   the rest  a zlib stream: the high bytes of all red values, of green and blue, then the low bytes
///
/// Values are half floats times 2^exponent, which puts the largest below 32768: every value down to 2^-29 of it keeps
/// its 11 bits. `rgb`: width · height · 3, rows from the top.
std::string encode_view_picture(nlohmann::ordered_json header, uint32_t width, uint32_t height,
                                const std::vector<float>& rgb);

/// A file for the page to keep, in the same form: a header {"file": name}, then its bytes as they are.
std::string encode_view_file(const std::string& name, const std::string& bytes);

struct ViewPicture {
  uint32_t width = 0, height = 0;
  std::string header;      ///< JSON
  std::vector<float> rgb;  ///< width · height · 3
};
/// The inverse, for tests and other clients. Throws Error{input} when the data are damaged.
ViewPicture decode_view_picture(std::string_view data);

}  // namespace lucarium
