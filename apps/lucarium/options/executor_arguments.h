// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "grammar/command_line.h"
#include "lucarium/compare/execute/piece_executor.h"
#include "options/options.h"

namespace lucarium::app {

/// What runs the pieces of a command: --executor and --slurm, and the devices that share them.
struct ExecutorArguments {
  std::string executor = "local";
  std::vector<std::string> slurm;
  void add_to(Command command);
  /// Throws Error{usage} for what cannot be, or does nothing.
  ExecutorOptions resolved(const DeviceArguments& device) const;
};

}  // namespace lucarium::app
