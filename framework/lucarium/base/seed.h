// SPDX-License-Identifier: Apache-2.0
// The seeds of kernels. They are part of every picture's bits: do not change them.
#pragma once
#include <cstdint>

namespace lucarium {

/// The 32 bits of a seed that kernels get.
inline uint32_t kernel_seed(uint64_t seed) { return static_cast<uint32_t>(seed ^ (seed >> 32)); }

/// A seed for each index (iteration, frame, batch) of something that has the seed `seed`; 0 keeps `seed`.
inline uint32_t indexed_seed(uint32_t seed, uint32_t index) { return seed ^ (index * 0x9e3779b9u); }

/// The same, with the bits spread once more, for seeds that are themselves indexed again.
inline uint32_t mixed_seed(uint32_t seed, uint32_t index) { return indexed_seed(seed, index) * 0x85ebca6bu; }

/// A seed for each index of a stream of its own: `stream` parts it from others of the same seed.
inline uint32_t stream_seed(uint32_t seed, uint32_t stream, uint32_t index) {
  return (seed ^ stream) * 0x9e3779b9u + index;
}

/// A seed for each frame of something whose samples within a frame have indexed_seed(); 0 keeps `seed`.
inline uint32_t frame_seed(uint32_t seed, uint32_t frame) { return seed ^ (frame * 0x85ebca6bu); }

}  // namespace lucarium
