// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace lucarium {

/// Which device performs which task next. Knows nothing of processes and threads.
class DeviceShares {
 public:
  /// `like`: one text per task; tasks with the same one (unless it is empty) go to the same device, as long as that
  /// does not fail. All of them are there, in the order of the list.
  DeviceShares(std::vector<std::string> like, size_t devices);

  /// The next task for this device; nothing: none is left that it may do now.
  std::optional<size_t> take(size_t device);
  /// Returns the devices that are set aside from now on.
  std::vector<size_t> finish(size_t task);
  /// Whether another device tries the task; else it has failed on all of them.
  bool fail(size_t task, size_t device);
  bool all_done() const { return open_ == 0; }
  size_t running() const { return running_; }

  /// Whether failures on this device were made good by others so often that it gets nothing more.
  bool set_aside(size_t device) const { return blame_[device] >= patience; }

  static constexpr size_t patience = 3;

 private:
  struct Task {
    std::string like;
    std::set<size_t> failed_on;
    bool waiting = true;
  };
  bool may_do(const Task& task, size_t device) const;

  std::vector<Task> tasks_;
  std::map<std::string, size_t> owner_;  ///< device of tasks that run alike
  std::vector<size_t> blame_;            ///< failures of a device that another one made good
  size_t first_waiting_ = 0;             ///< none before it waits
  size_t open_, running_ = 0;
};

}  // namespace lucarium
