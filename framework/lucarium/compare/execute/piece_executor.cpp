// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/execute/piece_executor.h"

#include "lucarium/compare/execute/local_executor.h"
#include "lucarium/compare/execute/slurm_executor.h"

namespace lucarium {

std::unique_ptr<PieceExecutor> make_executor(const ExecutorOptions& options, const std::filesystem::path& program,
                                             const std::filesystem::path& folder) {
  if (options.kind == ExecutorOptions::Kind::slurm)
    return std::make_unique<SlurmExecutor>(program, folder, options.slurm);
  return std::make_unique<LocalExecutor>(program, options.devices);
}

}  // namespace lucarium
