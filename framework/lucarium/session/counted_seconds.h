// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/session/session.h"

namespace lucarium {

/// Seconds of preparing (upload, BVH, the technique's own) and iterating, which budgets of time count; not of loading,
/// not of compiling.
inline double counted_seconds(const RenderSession::Clocks& clocks) {
  return clocks.upload + clocks.bvh + clocks.prepare + clocks.iterate;
}

/// Processor time of the same, of all threads of the process [s].
inline double counted_processor_seconds(const RenderSession::Clocks& clocks) {
  return clocks.prepare_processor + clocks.iterate_processor;
}

}  // namespace lucarium
