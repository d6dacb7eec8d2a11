// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "lucarium/base/hash.h"

namespace lucarium {

struct BuiltProgram;

/// The programs that a device used last. They stay built when nobody has them any more: the next session needs the same
/// ones. May be called by any thread.
class KeptPrograms {
 public:
  static constexpr size_t max_count = 64;

  /// The one that was asked for in these words, or null.
  std::shared_ptr<BuiltProgram> find(const Hash128& request) const;
  /// It is the one that was used last; above `max_count` the one used least recently goes.
  void keep(const Hash128& request, std::shared_ptr<BuiltProgram> program);
  void clear();
  size_t size() const;

 private:
  using Entry = std::pair<Hash128, std::shared_ptr<BuiltProgram>>;
  mutable std::mutex mutex_;
  std::vector<Entry> entries_;  // the last used one at the end
};

}  // namespace lucarium
