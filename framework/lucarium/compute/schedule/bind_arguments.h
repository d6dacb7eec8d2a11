// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "lucarium/compute/schedule/recorded_schedule.h"

namespace lucarium {

/// By convention the argument through which a sliced kernel learns where its slice begins; the schedule sets it.
inline constexpr std::string_view slice_base_argument = "slice_base";

/// What a pass does with one of its buffers, over all arguments that are bound to it.
struct BufferAccess {
  int resource = -1;
  bool writes = false;
  bool discards = false;  ///< overwrites the buffer without reading it
};

/// A checked pass: for every kernel argument, in order, the recorded one (null for slice_base when not bound).
struct BoundArguments {
  std::vector<const RecordedArgument*> by_position;
  std::vector<BufferAccess> accesses;
  int slice_base = -1;  ///< position of `uint slice_base`; -1: the kernel has none
};

/// Binds by name and checks kind, OpenCL type of by-value arguments, and aliasing: a buffer may be bound to several
/// arguments only if all of them are const or none is, because a const parameter promises that the buffer is not
/// written. Throws Error{device} that begins with `where` and names the argument and the nearest valid name.
BoundArguments bind_arguments(const std::string& where, const RecordedStep& step,
                              const std::vector<RecordedResource>& resources);

}  // namespace lucarium
