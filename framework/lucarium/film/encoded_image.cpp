// SPDX-License-Identifier: Apache-2.0
#include "lucarium/film/encoded_image.h"

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

std::optional<ImageSize> png_size(std::span<const uint8_t> png) {
  constexpr size_t width_at = 16, height_at = 20;  // in IHDR, which comes first
  if (png.size() < height_at + 4) return std::nullopt;
  return ImageSize{big_endian(png, width_at), big_endian(png, height_at)};
}

namespace {

/// Walks the segments of a JPEG up to the first scan: visit(marker, segment from its marker on). Returns the rest,
/// which begins with the marker of the scan; empty where a segment is not well formed.
template <class Visit>
std::span<const uint8_t> walk_jpeg(std::span<const uint8_t> jpeg, Visit&& visit) {
  constexpr uint8_t start_of_scan = 0xDA;
  size_t offset = 2;
  while (offset + 4 <= jpeg.size() && jpeg[offset] == 0xFF) {
    const uint8_t marker = jpeg[offset + 1];
    if (marker == 0xFF) {  // fill byte
      ++offset;
      continue;
    }
    if (marker == start_of_scan) return jpeg.subspan(offset);
    const size_t length = size_t(jpeg[offset + 2]) << 8 | jpeg[offset + 3];
    if (length < 2 || length > jpeg.size() - offset - 2) break;
    visit(marker, jpeg.subspan(offset, 2 + length));
    offset += 2 + length;
  }
  return {};
}

/// The frame header (SOF) of a JPEG and what follows it; ITU T.81, section B.2.2.
struct JpegFrame {
  std::span<const uint8_t> segment;  ///< with its marker; empty where there is none
  std::span<const uint8_t> scans;    ///< empty where there is none

  explicit JpegFrame(std::span<const uint8_t> jpeg) {
    scans = walk_jpeg(jpeg, [this](uint8_t marker, std::span<const uint8_t> found) {
      const bool is_frame = marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
      if (is_frame && segment.empty() && found.size() >= 10) segment = found;
    });
  }

  uint64_t number(size_t offset) const { return uint64_t{segment[offset]} << 8 | segment[offset + 1]; }
  ImageSize size() const { return {static_cast<uint32_t>(number(7)), static_cast<uint32_t>(number(5))}; }
  bool huffman() const { return segment[1] <= 0xC7; }

  /// Blocks of 8×8 values in all components, or 0 where the header makes no sense; section A.1.1.
  uint64_t blocks() const {
    const size_t components = segment[9];
    if (segment.size() < 10 + 3 * components) return 0;
    uint64_t max_h = 0, max_v = 0, count = 0;
    const auto sampling = [this](size_t c) { return segment[11 + 3 * c]; };
    for (size_t c = 0; c < components; ++c) {
      max_h = std::max<uint64_t>(max_h, sampling(c) >> 4);
      max_v = std::max<uint64_t>(max_v, sampling(c) & 15);
    }
    if (max_h == 0 || max_v == 0) return 0;
    for (size_t c = 0; c < components; ++c) {
      const uint64_t h = sampling(c) >> 4, v = sampling(c) & 15;
      count += ((size().width * h + 8 * max_h - 1) / (8 * max_h)) * ((size().height * v + 8 * max_v - 1) / (8 * max_v));
    }
    return count;
  }
};

}  // namespace

std::optional<ImageSize> jpeg_size(std::span<const uint8_t> jpeg) {
  const JpegFrame frame(jpeg);
  if (frame.segment.empty()) return std::nullopt;
  return frame.size();
}

std::string jpeg_damage(std::span<const uint8_t> jpeg) {
  const JpegFrame frame(jpeg);
  if (frame.segment.empty()) return "it states no size";
  if (frame.scans.empty()) return "it is cut off";
  // With Huffman codes the mean of each block takes one bit at least.
  return frame.huffman() && frame.scans.size() < frame.blocks() / 8 ? "it is cut off" : "";
}

std::vector<uint8_t> strip_jpeg_metadata(std::span<const uint8_t> jpeg) {
  constexpr uint8_t app0_jfif = 0xE0, app14_adobe = 0xEE, app15 = 0xEF, comment = 0xFE;
  std::vector<uint8_t> out;
  out.reserve(jpeg.size());
  append(out, jpeg.first(std::min<size_t>(jpeg.size(), 2)));
  const std::span<const uint8_t> scans = walk_jpeg(jpeg, [&](uint8_t marker, std::span<const uint8_t> segment) {
    // JFIF and Adobe's marker say how colours are stored; the other application data are metadata.
    const bool metadata = marker == comment || (marker > app0_jfif && marker <= app15 && marker != app14_adobe);
    if (!metadata) append(out, segment);
  });
  append(out, scans);
  return out;
}

}  // namespace lucarium
