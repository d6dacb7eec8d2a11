// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/compare/execute/piece_executor.h"

namespace lucarium {

/// Runs tasks on this machine: one process per device at a time, in the order of the list. A task that fails on a
/// device is tried on each of the others; a device whose failures others make good is set aside.
class LocalExecutor final : public PieceExecutor {
 public:
  /// `devices` as of ExecutorOptions.
  LocalExecutor(std::filesystem::path program, std::vector<std::string> devices);
  void run(const std::vector<PieceTask>& tasks, const PieceEvents& events) override;
  size_t width() const override { return std::max<size_t>(devices_.size(), 1); }

 private:
  std::filesystem::path program_;
  std::vector<std::string> devices_;
};

/// Performs a job (JSON) in a process of its own, on this machine, while it holds `lock` (empty: none).
PieceEnd perform_job(const std::filesystem::path& program, const std::string& job, const std::filesystem::path& lock,
                     const std::function<void(std::string_view)>& on_line,
                     const std::function<bool()>& stop_requested = {});

}  // namespace lucarium
