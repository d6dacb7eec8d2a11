// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/report/packed_image.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>

#include "lucarium/base/error.h"

namespace lucarium {

namespace {

constexpr int half_mantissa = 10;
constexpr int largest_half = 0x7bff;  // bits of 65504

/// Puts the median at 1, unless the largest value then does not fit; gives up at most ten stops at the dark end for it.
int choose_exponent(const std::vector<float>& values) {
  std::vector<float> magnitudes;
  magnitudes.reserve(values.size());
  float largest = 0;
  for (const float value : values) {
    if (!std::isfinite(value) || value == 0) continue;
    magnitudes.push_back(std::abs(value));
    largest = std::max(largest, std::abs(value));
  }
  if (magnitudes.empty()) return 0;
  const auto middle = magnitudes.begin() + static_cast<ptrdiff_t>(magnitudes.size() / 2);
  std::nth_element(magnitudes.begin(), middle, magnitudes.end());
  const int median = std::ilogb(*middle), fits = std::ilogb(largest) - 14;
  return std::clamp(fits, median, median + 10);
}

int hdr_code(float value, int exponent, int mantissa_bits) {
  const int shift = half_mantissa - mantissa_bits;
  if (std::isnan(value)) return 0x7e00 >> shift;
  int magnitude = 0x7c00 >> shift;
  if (std::isfinite(value)) {
    // Half floats have exponents biased by 15 instead of 127, and below 2^-14 steps of 2^-24. Rounded once, to the bits
    // kept.
    const float scaled = std::min(std::ldexp(std::abs(value), -exponent), 65504.0f);
    const uint32_t bits = std::bit_cast<uint32_t>(scaled) - (112u << 23);
    magnitude = scaled < 0x1p-14f ? static_cast<int>(std::lround(std::ldexp(scaled, 24 - shift)))
                                  : static_cast<int>((bits + (1u << (22 - mantissa_bits))) >> (23 - mantissa_bits));
    magnitude = std::min(magnitude, largest_half >> shift);
  }
  return std::signbit(value) ? -magnitude : magnitude;
}

float hdr_value(int code, int exponent, int mantissa_bits) {
  const int bits = std::abs(code) << (half_mantissa - mantissa_bits), biased = bits >> half_mantissa,
            mantissa = bits & 1023;
  float magnitude = std::ldexp(static_cast<float>(biased > 0 ? mantissa + 1024 : mantissa), std::max(biased, 1) - 25);
  if (biased == 31) magnitude = mantissa != 0 ? std::nanf("") : INFINITY;
  const float value = std::ldexp(magnitude, exponent);
  return code < 0 ? -value : value;
}

/// Predicts from the neighbours to the left, above and between; 0 left, 1 above, 2 mean, 3 gradient clamped to both
/// (the median predictor of LOCO-I, Weinberger et al. 2000).
int predict(int kind, int left, int above, int corner) {
  switch (kind) {
    case 0: return left;
    case 1: return above;
    case 2: return (left + above) >> 1;
    default: return std::clamp(left + above - corner, std::min(left, above), std::max(left, above));
  }
}
constexpr int predictors = 4;

/// Calls visit(x, prediction) for the pixels of row y; `plane` must hold everything before the pixel being visited.
template <class Visit>
void visit_row(const int* plane, uint32_t width, uint32_t y, int kind, Visit visit) {
  const int* row = plane + size_t{y} * width;
  const int* previous = y > 0 ? row - width : row;
  for (uint32_t x = 0; x < width; ++x) {
    const int above = y > 0 ? previous[x] : (x > 0 ? row[x - 1] : 0);
    const int left = x > 0 ? row[x - 1] : above;
    const int corner = x > 0 && y > 0 ? previous[x - 1] : above;
    visit(x, predict(kind, left, above, corner));
  }
}

int best_predictor(const int* plane, uint32_t width, uint32_t y) {
  int best = 0;
  int64_t least = INT64_MAX;
  for (int kind = 0; kind < predictors; ++kind) {
    int64_t sum = 0;
    const int* row = plane + size_t{y} * width;
    visit_row(plane, width, y, kind, [&](uint32_t x, int prediction) { sum += std::abs(row[x] - prediction); });
    if (sum < least) {
      least = sum;
      best = kind;
    }
  }
  return best;
}

std::string deflate_bytes(const std::string& bytes) {
  z_stream stream{};
  // Residuals are small numbers without repeated strings, which is what Z_FILTERED is for; higher levels gain nothing.
  if (deflateInit2(&stream, 4, Z_DEFLATED, 15, 9, Z_FILTERED) != Z_OK)
    throw_error(ErrorClass::internal, "zlib cannot be initialized");
  std::string packed(deflateBound(&stream, static_cast<uLong>(bytes.size())), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  const int status = deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  if (status != Z_STREAM_END)
    throw_error(ErrorClass::internal, "zlib cannot compress an image of {} bytes", bytes.size());
  return packed;
}

/// `planes`: codes, plane by plane.
std::string pack_planes(uint32_t width, uint32_t height, uint32_t channels, const std::vector<int>& planes) {
  const size_t pixels = size_t{width} * height, rows = size_t{height} * channels;
  std::string bytes(rows + 2 * planes.size(), '\0');
  for (size_t row = 0; row < rows; ++row) {
    const int* plane = planes.data() + row / height * pixels;
    const auto y = static_cast<uint32_t>(row % height);
    const int kind = best_predictor(plane, width, y);
    bytes[row] = static_cast<char>(kind);
    char* low = bytes.data() + rows + row * width;
    char* high = low + planes.size();
    visit_row(plane, width, y, kind, [&](uint32_t x, int prediction) {
      const int residual = plane[size_t{y} * width + x] - prediction;
      const auto zigzag = static_cast<uint32_t>(residual < 0 ? -2 * residual - 1 : 2 * residual);
      low[x] = static_cast<char>(zigzag & 255u);
      high[x] = static_cast<char>(zigzag >> 8);
    });
  }
  return deflate_bytes(bytes);
}

/// Codes of interleaved values as planes; of three channels the differences to green, which are small.
template <class Code>
std::vector<int> code_planes(size_t pixels, uint32_t channels, const std::vector<float>& values, Code code) {
  std::vector<int> planes(pixels * channels);
  for (size_t i = 0; i < pixels; ++i) {
    const int first = code(values[i * channels + (channels == 3 ? 1 : 0)]);
    planes[i] = first;
    if (channels != 3) continue;
    planes[pixels + i] = code(values[3 * i]) - first;
    planes[2 * pixels + i] = code(values[3 * i + 2]) - first;
  }
  return planes;
}

PackedImage pack(uint32_t width, uint32_t height, uint32_t channels, const std::vector<float>& values,
                 int mantissa_bits, int exponent) {
  const size_t pixels = size_t{width} * height;
  PackedImage image{width, height, channels, mantissa_bits, exponent, {}};
  const std::vector<int> planes = code_planes(pixels, channels, values, [&](float value) {
    if (mantissa_bits > 0) return hdr_code(value, exponent, mantissa_bits);
    return static_cast<int>(std::lround(255 * std::clamp(std::isfinite(value) ? value : 1.0f, 0.0f, 1.0f)));
  });
  image.data = pack_planes(width, height, channels, planes);
  return image;
}

}  // namespace

PackedImage pack_hdr(uint32_t width, uint32_t height, uint32_t channels, const std::vector<float>& values,
                     size_t byte_limit) {
  const int exponent = choose_exponent(values);
  PackedImage image = pack(width, height, channels, values, packed_mantissa_bits, exponent);
  while (image.data.size() > byte_limit && image.mantissa_bits > 1) {
    // A mantissa bit less saves at most one bit per value.
    const double excess_bits =
        8.0 * static_cast<double>(image.data.size() - byte_limit) / static_cast<double>(values.size());
    const int fewer = std::max(1, static_cast<int>(excess_bits));
    image = pack(width, height, channels, values, std::max(1, image.mantissa_bits - fewer), exponent);
  }
  return image;
}

PackedImage pack_unit(uint32_t width, uint32_t height, uint32_t channels, const std::vector<float>& values) {
  return pack(width, height, channels, values, 0, 0);
}

std::vector<float> unpack(const PackedImage& image) {
  const size_t pixels = size_t{image.width} * image.height, count = pixels * image.channels;
  const size_t rows = size_t{image.height} * image.channels;
  std::string bytes(rows + 2 * count, '\0');
  uLongf size = static_cast<uLongf>(bytes.size());
  const int status =
      uncompress(reinterpret_cast<Bytef*>(bytes.data()), &size, reinterpret_cast<const Bytef*>(image.data.data()),
                 static_cast<uLong>(image.data.size()));
  if (status != Z_OK || size != bytes.size()) throw_error(ErrorClass::input, "packed image: damaged data");
  std::vector<int> planes(count);
  for (size_t row = 0; row < rows; ++row) {
    int* plane = planes.data() + row / image.height * pixels;
    const auto y = static_cast<uint32_t>(row % image.height);
    const auto* low = reinterpret_cast<const uint8_t*>(bytes.data()) + rows + row * image.width;
    visit_row(plane, image.width, y, bytes[row], [&](uint32_t x, int prediction) {
      const int zigzag = low[x] | low[x + count] << 8;
      plane[size_t{y} * image.width + x] = prediction + ((zigzag & 1) != 0 ? -(zigzag >> 1) - 1 : zigzag >> 1);
    });
  }
  std::vector<float> values(count);
  for (size_t i = 0; i < count; ++i) {
    const size_t pixel = i / image.channels, channel = i % image.channels;
    int code = planes[pixel];
    if (image.channels == 3 && channel == 0) code += planes[pixels + pixel];
    if (image.channels == 3 && channel == 2) code += planes[2 * pixels + pixel];
    values[i] =
        image.mantissa_bits > 0 ? hdr_value(code, image.exponent, image.mantissa_bits) : static_cast<float>(code) / 255;
  }
  return values;
}

std::vector<float> reduce_image(uint32_t width, uint32_t height, uint32_t channels, const std::vector<float>& values,
                                uint32_t divisor) {
  if (divisor == 1) return values;
  const uint32_t columns = (width + divisor - 1) / divisor, rows = (height + divisor - 1) / divisor;
  std::vector<float> reduced(size_t{columns} * rows * channels);
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      const uint32_t column = x / divisor, row = y / divisor;
      const uint32_t across = std::min(divisor, width - column * divisor),
                     down = std::min(divisor, height - row * divisor);
      const float weight = 1.0f / static_cast<float>(across * down);
      const float* from = &values[(size_t{y} * width + x) * channels];
      float* to = &reduced[(size_t{row} * columns + column) * channels];
      for (uint32_t c = 0; c < channels; ++c) to[c] += weight * from[c];
    }
  }
  return reduced;
}

}  // namespace lucarium
