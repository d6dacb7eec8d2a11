// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/gltf/document/container.h"

namespace lucarium::gltf {

namespace {

constexpr std::string_view glb_magic = "glTF";
constexpr uint32_t chunk_json = 0x4E4F534A, chunk_binary = 0x004E4942;
constexpr size_t header_bytes = 12, chunk_header_bytes = 8;

uint32_t read_u32(std::string_view bytes, size_t offset) {
  uint32_t value = 0;
  for (int i = 3; i >= 0; --i) value = value << 8 | static_cast<uint8_t>(bytes[offset + i]);
  return value;
}

/// The bytes that the header declares.
std::string_view check_header(std::string_view bytes, ImportContext& context) {
  if (bytes.size() < header_bytes) context.fail("the GLB header is cut off: {} bytes of 12", bytes.size());
  const uint32_t version = read_u32(bytes, 4), length = read_u32(bytes, 8);
  if (version == 1) context.fail("this is a glTF 1.0 binary; only glTF 2.0 can be read, convert it first");
  if (version != 2) context.fail("GLB container version {} is unknown; only version 2 can be read", version);
  if (length < header_bytes) context.fail("the GLB header states a length of {} bytes, less than the header", length);
  if (length > bytes.size()) {
    context.fail("the GLB is cut off: its header states {} bytes but the file has {}", length, bytes.size());
  }
  if (length < bytes.size()) context.warn("{} bytes after the end of the GLB were ignored", bytes.size() - length);
  return bytes.substr(0, length);
}

Container split_glb(std::string_view bytes, ImportContext& context) {
  bytes = check_header(bytes, context);
  Container container;
  size_t offset = header_bytes;
  for (int chunk = 0; offset < bytes.size(); ++chunk) {
    if (bytes.size() - offset < chunk_header_bytes) context.fail("the header of GLB chunk {} is cut off", chunk);
    const uint32_t length = read_u32(bytes, offset), type = read_u32(bytes, offset + 4);
    offset += chunk_header_bytes;
    if (length > bytes.size() - offset) {
      context.fail("GLB chunk {} states {} bytes but only {} are left", chunk, length, bytes.size() - offset);
    }
    const std::string_view data = bytes.substr(offset, length);
    offset += length;
    if (chunk == 0) {
      if (type != chunk_json) context.fail("the first GLB chunk must be JSON; its type is {:#010x}", type);
      if (data.empty()) context.fail("the JSON chunk of the GLB is empty");
      container.json = data;
    } else if (type == chunk_json) {
      context.fail("GLB chunk {} is a second JSON chunk; there may be one", chunk);
    } else if (type == chunk_binary) {
      if (chunk != 1) context.fail("GLB chunk {} is a binary chunk; only the second chunk may be one", chunk);
      container.binary_chunk = data;
    } else {
      context.warn("GLB chunk {} of the unknown type {:#010x} was ignored", chunk, type);
    }
  }
  if (container.json.empty()) context.fail("the GLB has no JSON chunk");
  return container;
}

}  // namespace

Container split_container(std::string_view bytes, ImportContext& context) {
  if (bytes.substr(0, 4) == glb_magic) return split_glb(bytes, context);
  const std::string_view text = bytes.starts_with("\xEF\xBB\xBF") ? bytes.substr(3) : bytes;
  const size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) context.fail("the file is empty");
  if (text[first] != '{') context.fail("this is neither JSON nor a GLB, so not a glTF file");
  return {text, std::nullopt};
}

}  // namespace lucarium::gltf
