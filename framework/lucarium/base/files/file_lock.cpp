// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/files/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include "lucarium/base/error.h"
#include "lucarium/base/files/list_folder.h"
#include "lucarium/base/interrupt.h"

namespace lucarium {
namespace {

constexpr std::chrono::milliseconds between_attempts{50};

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
  if (try_lock(folder / ".lock")) return;
  throw_error(ErrorClass::usage, "{} is in use by another comparison; wait for it or choose another --output",
              folder.string());
}

FolderLock::~FolderLock() {
  namespace fs = std::filesystem;
  if (made_.empty()) return;
  std::error_code failure, ignored;
  if (list_folder(made_, failure).size() != 1 || failure) return;  // more than the lock
  fs::remove(made_ / ".lock", ignored);
  fs::remove(made_, ignored);
}

}  // namespace lucarium
