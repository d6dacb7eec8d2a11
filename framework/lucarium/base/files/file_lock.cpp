// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/files/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"

namespace lucarium {
namespace {

constexpr std::chrono::milliseconds between_attempts{50};

/// Whether an open file is still the one of that name: its holder may have removed it before this process got it.
bool is_file_of_name(int file, const std::filesystem::path& name) {
  struct stat opened {
  }, named{};
  return ::fstat(file, &opened) == 0 && ::stat(name.c_str(), &named) == 0 && opened.st_ino == named.st_ino &&
         opened.st_dev == named.st_dev;
}

}  // namespace

bool FileLock::try_lock(const std::filesystem::path& file) {
  file_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (file_ < 0) {
    throw_error(ErrorClass::input, "cannot write into {}: {}; choose another folder", file.parent_path().string(),
                std::strerror(errno));
  }
  return ::flock(file_, LOCK_EX | LOCK_NB) == 0;
}

FileLock::FileLock(const std::filesystem::path& file, const std::function<void()>& on_wait) {
  if (try_lock(file)) return;
  on_wait();
  // Asked again and again: a wait inside flock() would go on after a signal.
  while (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK && errno != EINTR) {
      const int reason = errno;
      ::close(file_);
      throw_error(ErrorClass::input, "cannot lock {}: {}", file.string(), std::strerror(reason));
    }
    if (interrupt_requested()) {
      ::close(file_);
      throw_error(ErrorClass::interrupted, "interrupted while waiting for {}", file.string());
    }
    std::this_thread::sleep_for(between_attempts);
  }
}

FileLock::~FileLock() { ::close(file_); }

FolderLock::FolderLock(const std::filesystem::path& folder) {
  std::error_code failure;
  if (std::filesystem::create_directories(folder, failure)) made_ = folder;
  if (failure)
    throw_error(ErrorClass::input, "cannot write into {}: {}; choose another folder", folder.string(),
                failure.message());
  lock_ = folder / ".lock";
  while (try_lock(lock_)) {
    if (is_file_of_name(file_, lock_)) return;
    ::close(file_);
  }
  ::close(file_);
  throw_error(ErrorClass::usage, "{} is in use by another comparison; wait for it or choose another --output",
              folder.string());
}

FolderLock::~FolderLock() {
  namespace fs = std::filesystem;
  std::error_code ignored;
  fs::remove(lock_, ignored);
  if (!made_.empty()) fs::remove(made_, ignored);  // unless something is in it
}

}  // namespace lucarium
