// SPDX-License-Identifier: Apache-2.0
// Which launch code a compiled pass needs of the driver: internal to compute/.
#pragma once
#include <array>
#include <string>

#include "lucarium/compute/schedule/bind_arguments.h"
#include "lucarium/compute/schedule/schedule_state.h"

namespace lucarium {

/// PoCL compiles grids from this width on separately (its grid_width_specialization_limit).
inline constexpr size_t pocl_large_grid = 65536;

/// `global` rounded up to whole work-groups.
std::array<size_t, 3> whole_groups(std::array<size_t, 3> global, const std::array<size_t, 3>& local);
/// The smallest large grid of a pass: what a warm-up launches where a counter decides the size.
std::array<size_t, 3> large_grid(const CompiledStep& step);

/// Names the code of a launch of `global` work-items for KernelCompilers.
std::string launch_code_id(const CompiledStep& step, const std::array<size_t, 3>& global);

/// Has other processes compile what the pass will need, where there are some and its program was compiled here.
void want_launch_code(const RecordedSchedule& recorded, const CompiledStep& step, const BoundArguments& bound);

}  // namespace lucarium
