// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/image/encoded_image.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace lucarium {

namespace {

void append(std::vector<uint8_t>& out, std::span<const uint8_t> bytes) {
  out.insert(out.end(), bytes.begin(), bytes.end());
}

constexpr size_t signature_bytes = 8, around_data = 12;  ///< of a PNG; length, type and checksum of a chunk

uint32_t big_endian(std::span<const uint8_t> bytes, size_t offset) {
  uint32_t value = 0;
  for (size_t i = 0; i < 4; ++i) value = value << 8 | bytes[offset + i];
  return value;
}

/// CRC-32 of PNG (ISO 15948, annex D).
uint32_t checksum(std::span<const uint8_t> bytes) {
  static const std::array<uint32_t, 256> table = [] {
    std::array<uint32_t, 256> values{};
    for (uint32_t i = 0; i < 256; ++i) {
      values[i] = i;
      for (int bit = 0; bit < 8; ++bit) values[i] = values[i] & 1 ? 0xEDB88320u ^ values[i] >> 1 : values[i] >> 1;
    }
    return values;
  }();
  uint32_t crc = 0xFFFFFFFFu;
  for (const uint8_t byte : bytes) crc = table[(crc ^ byte) & 255] ^ crc >> 8;
  return ~crc;
}

}  // namespace

std::string png_damage(std::span<const uint8_t> png) {
  size_t offset = signature_bytes;
  while (offset + around_data <= png.size()) {
    const uint64_t length = big_endian(png, offset);
    if (length > png.size() - offset - around_data) break;
    const std::string_view type(reinterpret_cast<const char*>(png.data()) + offset + 4, 4);
    if (checksum(png.subspan(offset + 4, 4 + length)) != big_endian(png, offset + 8 + length))
      return "a checksum is wrong";
    if (type == "IEND") return "";
    offset += around_data + length;
  }
  return "it is cut off";
}

std::vector<uint8_t> strip_png_metadata(std::span<const uint8_t> png) {
  std::vector<uint8_t> out;
  out.reserve(png.size());
  append(out, png.first(std::min(png.size(), signature_bytes)));
  size_t offset = signature_bytes;
  while (offset + around_data <= png.size()) {
    const uint64_t length = big_endian(png, offset);
    if (length > png.size() - offset - around_data) break;
    const std::string_view type(reinterpret_cast<const char*>(png.data()) + offset + 4, 4);
    const bool critical = type[0] >= 'A' && type[0] <= 'Z';
    if (critical || type == "tRNS") append(out, png.subspan(offset, around_data + length));
    if (type == "IEND") break;
    offset += around_data + length;
  }
  return out;
}

std::vector<uint8_t> strip_jpeg_metadata(std::span<const uint8_t> jpeg) {
  constexpr uint8_t start_of_scan = 0xDA, app0_jfif = 0xE0, app14_adobe = 0xEE, app15 = 0xEF, comment = 0xFE;
  std::vector<uint8_t> out;
  out.reserve(jpeg.size());
  append(out, jpeg.first(std::min<size_t>(jpeg.size(), 2)));
  size_t offset = 2;
  while (offset + 4 <= jpeg.size()) {
    if (jpeg[offset] != 0xFF) break;
    const uint8_t marker = jpeg[offset + 1];
    if (marker == 0xFF) {  // fill byte
      ++offset;
      continue;
    }
    const size_t length = size_t(jpeg[offset + 2]) << 8 | jpeg[offset + 3];
    if (marker == start_of_scan || length < 2 || length > jpeg.size() - offset - 2) break;
    // JFIF and Adobe's marker say how colours are stored; the other application data are metadata.
    const bool metadata = marker == comment || (marker > app0_jfif && marker <= app15 && marker != app14_adobe);
    if (!metadata) append(out, jpeg.subspan(offset, 2 + length));
    offset += 2 + length;
  }
  const bool at_scan = offset + 1 < jpeg.size() && jpeg[offset] == 0xFF && jpeg[offset + 1] == start_of_scan;
  if (at_scan) append(out, jpeg.subspan(offset));
  return out;
}

}  // namespace lucarium
