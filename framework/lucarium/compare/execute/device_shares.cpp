// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/execute/device_shares.h"

#include <algorithm>

namespace lucarium {

DeviceShares::DeviceShares(std::vector<std::string> like, size_t devices) : blame_(devices, 0), open_(like.size()) {
  for (std::string& text : like) tasks_.push_back({std::move(text), {}, true});
}

bool DeviceShares::may_do(const Task& task, size_t device) const {
  if (!task.waiting || task.failed_on.contains(device)) return false;
  if (set_aside(device)) {  // only what all others have failed
    for (size_t other = 0; other < blame_.size(); ++other)
      if (!set_aside(other) && !task.failed_on.contains(other)) return false;
  }
  if (task.like.empty() || !task.failed_on.empty()) return true;
  const auto owner = owner_.find(task.like);
  return owner == owner_.end() || owner->second == device || set_aside(owner->second);
}

std::optional<size_t> DeviceShares::take(size_t device) {
  while (first_waiting_ < tasks_.size() && !tasks_[first_waiting_].waiting) ++first_waiting_;
  for (size_t task = first_waiting_; task < tasks_.size(); ++task) {
    if (!may_do(tasks_[task], device)) continue;
    tasks_[task].waiting = false;
    if (tasks_[task].failed_on.empty()) owner_[tasks_[task].like] = device;
    ++running_;
    return task;
  }
  return std::nullopt;
}

std::vector<size_t> DeviceShares::finish(size_t task) {
  std::vector<size_t> idle;
  for (const size_t other : tasks_[task].failed_on) {
    if (++blame_[other] == patience) idle.push_back(other);
  }
  --running_;
  --open_;
  return idle;
}

bool DeviceShares::fail(size_t task, size_t device) {
  Task& failed = tasks_[task];
  failed.failed_on.insert(device);
  --running_;
  if (failed.failed_on.size() == blame_.size()) {
    --open_;
    return false;
  }
  failed.waiting = true;
  first_waiting_ = std::min(first_waiting_, task);
  return true;
}

}  // namespace lucarium
