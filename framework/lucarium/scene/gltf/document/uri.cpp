// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/gltf/document/uri.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <optional>

namespace lucarium::gltf {

namespace {

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// Percent signs that start no escape stay unchanged: exporters forget to encode them.
std::string decode_percent(std::string_view text) {
  std::string result;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '%' && i + 2 < text.size() && hex_digit(text[i + 1]) >= 0 && hex_digit(text[i + 2]) >= 0) {
      result += static_cast<char>(hex_digit(text[i + 1]) * 16 + hex_digit(text[i + 2]));
      i += 2;
    } else {
      result += text[i];
    }
  }
  return result;
}

int base64_digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+' || c == '-') return 62;
  if (c == '/' || c == '_') return 63;
  return -1;
}

/// Empty when a character does not belong there.
std::optional<Bytes> decode_base64(std::string_view text) {
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  if (text.size() % 4 == 1) return std::nullopt;
  Bytes bytes;
  bytes.reserve(text.size() / 4 * 3 + 3);
  uint32_t bits = 0;
  int held = 0;
  for (const char c : text) {
    const int digit = base64_digit(c);
    if (digit < 0) return std::nullopt;
    bits = bits << 6 | static_cast<uint32_t>(digit);
    held += 6;
    if (held < 8) continue;
    held -= 8;
    bytes.push_back(static_cast<uint8_t>(bits >> held));
  }
  return bytes;
}

Bytes read_data_uri(const std::string& uri, const std::string& where, const ImportContext& context) {
  const size_t comma = uri.find(',');
  if (comma == std::string::npos)
    context.fail("{}: the data URI {} has no comma before its data", where, shown_uri(uri));
  const std::string_view head(uri.data(), comma), data = std::string_view(uri).substr(comma + 1);
  if (!head.ends_with(";base64")) {
    const std::string plain = decode_percent(data);
    return Bytes(plain.begin(), plain.end());
  }
  auto bytes = decode_base64(data.find('%') == std::string_view::npos ? std::string(data) : decode_percent(data));
  if (!bytes) context.fail("{}: the data URI {} is not valid base64", where, shown_uri(uri));
  return std::move(*bytes);
}

/// Length of "scheme:" at the start (RFC 3986, section 3.1), or 0.
size_t scheme_length(const std::string& uri) {
  const size_t colon = uri.find(':');
  if (colon == std::string::npos || colon == 0) return 0;
  for (size_t i = 0; i < colon; ++i) {
    const char c = uri[i];
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    const bool other = (c >= '0' && c <= '9') || c == '+' || c == '-' || c == '.';
    if (!letter && !(other && i > 0)) return 0;
  }
  return colon + 1;
}

std::filesystem::path resolve(const std::string& uri, const std::filesystem::path& folder, const std::string& where,
                              const ImportContext& context) {
  const std::string decoded = decode_percent(uri);
  if (decoded.empty() || decoded.find('\0') != std::string::npos) {
    context.fail("{}: the URI '{}' is not a file name", where, shown_uri(uri));
  }
  const std::filesystem::path relative = std::filesystem::path(decoded).lexically_normal();
  if (relative.is_absolute() || decoded.starts_with('\\') || *relative.begin() == "..") {
    context.fail("{}: '{}' lies outside the folder of the scene; move the file into it and use a relative path", where,
                 shown_uri(uri));
  }
  std::error_code ignored;
  const std::filesystem::path raw = std::filesystem::path(uri).lexically_normal();
  if (!std::filesystem::exists(folder / relative, ignored) && raw.is_relative() && !raw.empty() &&
      *raw.begin() != ".." && std::filesystem::exists(folder / raw, ignored)) {
    return folder / raw;  // its percent signs were meant literally
  }
  return folder / relative;
}

}  // namespace

std::string shown_uri(const std::string& uri) { return uri.size() <= 60 ? uri : uri.substr(0, 57) + "..."; }

Bytes read_file(const std::filesystem::path& file, uint64_t limit, const std::string& where,
                const ImportContext& context) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) context.fail("{}there is no file '{}'", where, file.string());
  if (!std::filesystem::is_regular_file(status)) context.fail("{}'{}' is not a regular file", where, file.string());
  const uint64_t size = std::min<uint64_t>(std::filesystem::file_size(file, error), limit);
  std::ifstream stream(file, std::ios::binary);
  if (error || !stream) context.fail("{}'{}' cannot be opened: {}", where, file.string(), std::strerror(errno));
  Bytes bytes(size);
  if (size && !stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size))) {
    context.fail("{}'{}' cannot be read to its end", where, file.string());
  }
  return bytes;
}

Bytes read_uri(const std::string& uri, const std::filesystem::path& folder, uint64_t limit, const std::string& where,
               const ImportContext& context) {
  if (uri.starts_with("data:")) return read_data_uri(uri, where, context);
  if (const size_t length = scheme_length(uri)) {
    context.fail("{}: '{}' URIs are not loaded ('{}'); put the file beside the scene and use a relative path", where,
                 uri.substr(0, length), shown_uri(uri));
  }
  return read_file(resolve(uri, folder, where, context), limit, where + ": ", context);
}

}  // namespace lucarium::gltf
