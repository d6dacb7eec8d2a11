// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/schedule/launch_code.h"

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "lucarium/compute/device/kernel_compilers.h"

namespace lucarium {
namespace {

constexpr size_t large_width = 65535;

bool is_large(const std::array<size_t, 3>& global) { return std::max(global[0], global[1]) >= large_width; }

std::vector<LaunchCode::Argument> arguments_of(const RecordedSchedule& recorded, const BoundArguments& bound) {
  using Kind = LaunchCode::Argument::Kind;
  std::vector<LaunchCode::Argument> arguments;
  for (const RecordedArgument* argument : bound.by_position) {
    if (!argument) {
      arguments.push_back({Kind::value, sizeof(cl_uint)});  // slice_base
    } else if (argument->kind == RecordedArgument::Kind::value) {
      arguments.push_back({Kind::value, argument->bytes});
    } else if (argument->kind == RecordedArgument::Kind::variable) {
      arguments.push_back({Kind::value, recorded.variables[static_cast<size_t>(argument->index)].value.size()});
    } else {
      const bool is_local = argument->kind == RecordedArgument::Kind::local;
      arguments.push_back({is_local ? Kind::local : Kind::buffer, argument->bytes});
    }
  }
  return arguments;
}

}  // namespace

std::array<size_t, 3> whole_groups(std::array<size_t, 3> global, const std::array<size_t, 3>& local) {
  for (size_t d = 0; d < 3; ++d) global[d] = (global[d] + local[d] - 1) / local[d] * local[d];
  return global;
}

bool large_code_serves_small_grids(const DeviceInfo& device) { return std::atoi(device.driver_version.c_str()) < 4; }

std::array<size_t, 3> large_grid(const CompiledStep& step) {
  return whole_groups({large_width, step.global[1], step.global[2]}, step.local);
}

std::string launch_code_id(const CompiledStep& step, const std::array<size_t, 3>& global) {
  return step.launch + (is_large(global) ? "/large" : "/small");
}

std::array<size_t, 3> launched_grid(const CompiledStep& step, std::array<size_t, 3> global) {
  if (step.slice_items > 0) global[0] = std::min(global[0], step.slice_items);
  return whole_groups(global, step.local);
}

void want_launch_code(const RecordedSchedule& recorded, const CompiledStep& step, const BoundArguments& bound) {
  KernelCompilers* compilers = recorded.device->kernel_compilers();
  if (!compilers) return;
  std::array<size_t, 3> global = step.global;
  for (size_t& items : global) items = std::max<size_t>(items, 1);
  const auto want = [&](const std::array<size_t, 3>& size) {
    if (!step.program.lacks_launch_code(step.kernel_name, step.local, is_large(size))) return;
    const ProgramSource& source = step.program.source();
    compilers->want({launch_code_id(step, size), source.file, source.options, step.kernel_name, size, step.local,
                     arguments_of(recorded, bound)});
  };
  const bool of_any_class = step.counter >= 0 && step.slice_items == 0;
  if (of_any_class) want(large_grid(step));
  if (!of_any_class || !large_code_serves_small_grids(recorded.device->info())) want(launched_grid(step, global));
}

}  // namespace lucarium
