// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace lucarium {

/// An image as the report carries it; report/image_decoding.js is the reader.
///
/// Values are half floats times 2^exponent of which `mantissa_bits` (1 to 8) are kept, so that every value above the
/// subnormal range is within a relative 2^-(mantissa_bits+1), and steps are nearly logarithmic. Sign and truncated bits
/// make one integer code; non-finite values keep codes of their own. With `mantissa_bits` 0 the values are in [0,1] and
/// the code is round(255 v). Three channels become the planes G, R−G, B−G of codes; rows of a plane are predicted like
/// those of PNG, residuals are zigzag-coded in 16 bits, and `data` is a zlib stream of: one predictor byte per row and
/// plane, the low bytes of all residuals, their high bytes.
struct PackedImage {
  uint32_t width = 0, height = 0;
  uint32_t channels = 0;  ///< 1 or 3
  int mantissa_bits = 0;
  int exponent = 0;
  std::string data;
};

/// Largest number of mantissa bits: 0.2 % of a value.
inline constexpr int packed_mantissa_bits = 8;

/// Packs `values` (width · height · channels, rows from the top) with as many mantissa bits as fit into `byte_limit`,
/// but at least one. Values more than 25 stops above the median of those that are not 0 are clamped.
PackedImage pack_hdr(uint32_t width, uint32_t height, uint32_t channels, const std::vector<float>& values,
                     size_t byte_limit = SIZE_MAX);

/// Packs values in [0,1] at 8 bits.
PackedImage pack_unit(uint32_t width, uint32_t height, uint32_t channels, const std::vector<float>& values);

/// The values that the page will show. Throws Error{input} when `data` is damaged.
std::vector<float> unpack(const PackedImage& image);

/// Means of divisor × divisor pixels, cut at the right and lower edge; not finite where one of them is not.
/// Sizes become ceil(size / divisor).
std::vector<float> reduce_image(uint32_t width, uint32_t height, uint32_t channels, const std::vector<float>& values,
                                uint32_t divisor);

}  // namespace lucarium
