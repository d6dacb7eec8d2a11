// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/device/kept_programs.h"

#include <algorithm>

namespace lucarium {

std::shared_ptr<BuiltProgram> KeptPrograms::find(const Hash128& request) const {
  const std::lock_guard lock(mutex_);
  const auto found = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.first == request; });
  return found == entries_.end() ? nullptr : found->second;
}

void KeptPrograms::keep(const Hash128& request, std::shared_ptr<BuiltProgram> program) {
  std::vector<Entry> gone;  // behind the lock: releasing one calls the driver
  const std::lock_guard lock(mutex_);
  const auto same = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.first == request; });
  if (same != entries_.end()) {
    gone.push_back(std::move(*same));
    entries_.erase(same);
  }
  entries_.emplace_back(request, std::move(program));
  if (entries_.size() <= max_count) return;
  gone.push_back(std::move(entries_.front()));
  entries_.erase(entries_.begin());
}

void KeptPrograms::clear() {
  std::vector<Entry> gone;
  const std::lock_guard lock(mutex_);
  gone.swap(entries_);
}

size_t KeptPrograms::size() const {
  const std::lock_guard lock(mutex_);
  return entries_.size();
}

}  // namespace lucarium
