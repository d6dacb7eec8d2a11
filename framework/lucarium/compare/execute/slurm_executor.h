// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/compare/execute/piece_executor.h"

namespace lucarium {

/// Hands tasks to Slurm as job arrays over a folder that all nodes see (docs/slurm.md). Tasks that run alike are one
/// task of an array, which gets its node for itself. After an interrupt the jobs go on, and a later run() with the same
/// tasks and folder attaches to them. What fails or gets lost is tried again, on other nodes where there are any.
class SlurmExecutor final : public PieceExecutor {
 public:
  /// `folder`: of its files; made, and removed when nothing is left to do. `options`: of sbatch, "partition=long".
  /// Throws Error{usage} for options that it sets itself, and for a folder whose name Slurm would not understand.
  SlurmExecutor(std::filesystem::path program, const std::filesystem::path& folder, std::vector<std::string> options);
  void run(const std::vector<PieceTask>& tasks, const PieceEvents& events) override;
  size_t width() const override { return 64; }
  bool shows_progress() const override { return true; }
  bool keeps_tasks() const override { return true; }

 private:
  std::filesystem::path program_, folder_;
  std::vector<std::string> options_;
};

/// How often a task is tried.
inline constexpr size_t slurm_attempts = 3;

}  // namespace lucarium
