// SPDX-License-Identifier: Apache-2.0
// Bytes of a state file, little-endian. docs/state_files.md draws them.
#pragma once
#include <bit>
#include <cstdint>

#include "lucarium/base/hash.h"

namespace lucarium::state_layout {

static_assert(std::endian::native == std::endian::little);

inline constexpr char magic[8] = {'L', 'U', 'C', 'S', 'T', 'A', 'T', 'E'};
inline constexpr uint32_t schema = 1;
inline constexpr uint32_t max_header_bytes = 1 << 20;
inline constexpr uint32_t max_name_bytes = 64;
inline constexpr uint32_t max_element_bytes = 1 << 16;
inline constexpr uint64_t max_ratio = 1032;  ///< zlib compresses by no more

/// At the beginning; the header's text follows.
struct Start {
  char magic[8];
  uint32_t schema;
  uint32_t header_bytes;
  Hash128 checksum;  ///< of the 16 bytes before, and of the text
};
static_assert(sizeof(Start) == 32);

inline constexpr char chunk_mark[4] = {'C', 'H', 'N', 'K'}, end_mark[4] = {'L', 'A', 'S', 'T'};
enum class Encoding : uint32_t { plain = 0, zlib = 1 };

/// Before every chunk: its name and its data follow. The last one stands for the end of the file.
struct Record {
  char mark[4];
  uint32_t name_bytes;
  uint32_t element_bytes;
  Encoding encoding;
  uint64_t elements;  ///< of the last one: how many chunks came before
  uint64_t stored_bytes;
  Hash128 data;      ///< of the stored bytes; of the last one: of all records before
  Hash128 checksum;  ///< of the 48 bytes before, and of the name
};
static_assert(sizeof(Record) == 64);

}  // namespace lucarium::state_layout
