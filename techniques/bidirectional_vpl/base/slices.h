// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>

namespace lucarium::bidirectional {

inline constexpr size_t kSlice = 1 << 15;         ///< pixels or rays between two looks whether to stop
inline constexpr uint32_t kCountChunk = 1 << 14;  ///< what one work item counts

}  // namespace lucarium::bidirectional
