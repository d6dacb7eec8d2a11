// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <functional>

namespace lucarium {

/// Keeps other processes out while it lives. Released when the process ends, however it ends; the (empty) file stays,
/// except that of a FolderLock.
class FileLock {
 public:
  /// Waits until it is free; `on_wait` is called once before. Throws Error{input} when the file cannot be made.
  FileLock(const std::filesystem::path& file, const std::function<void()>& on_wait);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 protected:
  FileLock() = default;
  /// Opens the file; returns whether the lock could be had at once.
  bool try_lock(const std::filesystem::path& file);
  int file_ = -1;
};

/// Holds a result folder for one run: two at once would overwrite each other's results. Its file is removed at the end,
/// and a folder that it made and that is still empty: a command that was mistaken leaves nothing behind.
class FolderLock : private FileLock {
 public:
  /// Throws Error{usage} when another process holds the folder, Error{input} when it is not writable.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();

 private:
  std::filesystem::path lock_;  ///< the file
  std::filesystem::path made_;  ///< the folder, if it was not there before
};

}  // namespace lucarium
