// SPDX-License-Identifier: Apache-2.0
#include "options/executor_arguments.h"

#include "lucarium/base/error.h"

namespace lucarium::app {

void ExecutorArguments::add_to(Command command) {
  command.option("--executor", executor).check(one_of({"local", "slurm"})).capture_default_str();
  command.option("--slurm", slurm).repeatable().default_text("none");
}

ExecutorOptions ExecutorArguments::resolved(const DeviceArguments& device) const {
  ExecutorOptions options;
  options.devices = device.shared();
  options.slurm = slurm;
  if (executor == "slurm") options.kind = ExecutorOptions::Kind::slurm;
  if (options.kind == ExecutorOptions::Kind::slurm && !options.devices.empty())
    throw_error(ErrorClass::usage, "give several devices or --executor slurm, not both");
  if (options.kind == ExecutorOptions::Kind::local && !slurm.empty())
    throw_error(ErrorClass::usage, "--slurm {} does nothing without --executor slurm", slurm.front());
  return options;
}

}  // namespace lucarium::app
