// SPDX-License-Identifier: Apache-2.0
// Which launch code a compiled pass needs of the driver: internal to compute/.
#pragma once
#include <array>
#include <string>

#include "lucarium/compute/schedule/bind_arguments.h"
#include "lucarium/compute/schedule/schedule_state.h"

namespace lucarium {

/// Whether the driver takes code for small grids from what it has loaded for large ones, as long as the process lives.
/// PoCL compiles grids of 65535 work-items and more along x or y separately (its grid_width_specialization_limit); it
/// may drop code from memory from version 4 on.
bool large_code_serves_small_grids(const DeviceInfo& device);

/// `global` rounded up to whole work-groups.
std::array<size_t, 3> whole_groups(std::array<size_t, 3> global, const std::array<size_t, 3>& local);
/// A small one of the grids that are large.
std::array<size_t, 3> large_grid(const CompiledStep& step);

/// The first launch of a pass of `global` work-items: a slice of it where it is cut.
std::array<size_t, 3> launched_grid(const CompiledStep& step, std::array<size_t, 3> global);

/// Names the code of a launch of `global` work-items for KernelCompilers.
std::string launch_code_id(const CompiledStep& step, const std::array<size_t, 3>& global);

/// Has other processes compile what the pass will need and the driver has not, where there are some.
void want_launch_code(const RecordedSchedule& recorded, const CompiledStep& step, const BoundArguments& bound);

}  // namespace lucarium
