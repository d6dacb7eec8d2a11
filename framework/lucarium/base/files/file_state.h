// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <sys/stat.h>

#include <cstdint>
#include <filesystem>

namespace lucarium {

/// Which file has a name: equal until it is replaced or written to.
class FileState {
 public:
  FileState() = default;
  explicit FileState(const std::filesystem::path& file) {
    struct stat found {};
    if (::stat(file.c_str(), &found) != 0) return;
    exists_ = true;
    number_ = found.st_ino;
    size_ = found.st_size;
    seconds_ = found.st_mtim.tv_sec;
    nanoseconds_ = found.st_mtim.tv_nsec;
  }

  bool exists() const { return exists_; }
  bool operator==(const FileState&) const = default;

 private:
  bool exists_ = false;
  uint64_t number_ = 0;
  int64_t size_ = 0, seconds_ = 0, nanoseconds_ = 0;
};

}  // namespace lucarium
