// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>

#include "lucarium/compute/schedule/scheduler.h"

namespace lucarium::bidirectional {

/// Shadow rays of a pass of camera paths, which a map answers as far as it can.
struct ShadowRays {
  BufferRef rays, active;  ///< active: one element, how many
  BufferRef hits;          ///< surfaces that are lit
  BufferRef sources;       ///< what lights them
  BufferRef light;         ///< changed by what maps show
  BufferRef traced;        ///< written: the rays that are left
  BufferRef hidden;        ///< written in place of these two where maps answer all: what any-hit rays find
  uint32_t capacity;
  std::optional<Variable<uint32_t>> number = {};  ///< of the virtual light that all lead to, where it is one
};

}  // namespace lucarium::bidirectional
