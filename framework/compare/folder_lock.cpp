// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "lucarium/base/error.h"

namespace lucarium {

FolderLock::FolderLock(const std::filesystem::path& folder) {
  std::error_code failure;
  std::filesystem::create_directories(folder, failure);
  const std::filesystem::path file = folder / ".lock";
  file_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (file_ < 0) {
    throw_error(ErrorClass::input, "cannot write into {}: {}; choose another folder with --output", folder.string(),
                failure ? failure.message() : std::strerror(errno));
  }
  if (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
    ::close(file_);
    throw_error(ErrorClass::usage, "{} is in use by another comparison; wait for it or choose another --output",
                folder.string());
  }
}

FolderLock::~FolderLock() { ::close(file_); }

}  // namespace lucarium
