// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

namespace lucarium {

/// Holds a result folder for one run: two at once would overwrite each other's results. Released when the process ends,
/// however it ends.
class FolderLock {
 public:
  /// Throws Error{usage} when another process holds the folder, Error{input} when it is not writable.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_ = -1;
};

}  // namespace lucarium
