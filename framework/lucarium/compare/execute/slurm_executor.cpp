// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/execute/slurm_executor.h"

#include "lucarium/base/error.h"
#include "lucarium/compare/execute/array_run.h"
#include "lucarium/compare/execute/slurm_commands.h"

namespace lucarium {
namespace fs = std::filesystem;

SlurmExecutor::SlurmExecutor(fs::path program, const fs::path& folder, std::vector<std::string> options)
    : program_(std::move(program)), folder_(fs::absolute(folder)), options_(std::move(options)) {
  check_slurm_options(options_);
  if (folder_.string().find_first_of("%\\\n") != std::string::npos)
    throw_error(ErrorClass::usage, "{}: Slurm takes no folder with % or \\ in its name; choose another --output",
                folder_.string());
}

void SlurmExecutor::run(const std::vector<PieceTask>& tasks, const PieceEvents& events) {
  if (!tasks.empty()) ArrayRun(program_, folder_, options_, tasks, events).run();
}

}  // namespace lucarium
