// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/device/pocl_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <ctime>
#include <optional>

#include "lucarium/base/error.h"

namespace lucarium {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view name_prefix = "lucarium-driver-";
constexpr const char* lock_name = "in_use";
constexpr time_t set_up_seconds = 86400;  // far more than it takes from the folder's creation to its lock
constexpr uintmax_t roomy_bytes = uintmax_t{256} << 20;

std::string reason(int code) { return std::generic_category().message(code); }

/// Tries to write a file in `folder`; optionally also to map it executable.
std::string try_file(const fs::path& folder, bool executable) {
  std::string probe = (folder / ".probe-XXXXXX").string();
  const int file = mkostemp(probe.data(), O_CLOEXEC);
  if (file < 0) return reason(errno);
  std::string problem;
  if (write(file, "probe", 5) != 5) problem = reason(errno);
  if (problem.empty() && executable) {
    void* mapped = mmap(nullptr, 5, PROT_READ | PROT_EXEC, MAP_PRIVATE, file, 0);
    if (mapped == MAP_FAILED)
      problem = "mounted noexec";
    else
      munmap(mapped, 5);
  }
  close(file);
  unlink(probe.c_str());
  return problem;
}

bool is_roomy(const fs::path& folder) {
  struct statvfs status {};
  return statvfs(folder.c_str(), &status) == 0 && uintmax_t{status.f_bavail} * status.f_frsize >= roomy_bytes;
}

std::string owned_prefix() { return fmt::format("{}{}-", name_prefix, getuid()); }

/// Removes folders of processes that were killed: their lock is free, or was never given its name.
void remove_abandoned(const fs::path& place) {
  std::error_code failure;
  for (fs::directory_iterator entry(place, failure), end; !failure && entry != end; entry.increment(failure)) {
    struct stat status {};
    if (!entry->path().filename().string().starts_with(owned_prefix())) continue;
    if (lstat(entry->path().c_str(), &status) != 0 || !S_ISDIR(status.st_mode) || status.st_uid != getuid()) continue;
    const int lock = open((entry->path() / lock_name).c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW);
    const bool is_abandoned = lock >= 0 ? flock(lock, LOCK_EX | LOCK_NB) == 0
                                        : errno == ENOENT && time(nullptr) - status.st_mtime > set_up_seconds;
    if (is_abandoned) {
      std::error_code ignored;
      fs::remove_all(entry->path(), ignored);
    }
    if (lock >= 0) close(lock);
  }
}

fs::path temporary_place() {
  std::error_code failure;
  const fs::path place = fs::temp_directory_path(failure);
  return failure ? fs::path("/tmp") : place;
}

/// The first place that will do, best with room to spare.
fs::path choose_place(const fs::path& cache_dir) {
  std::string problems;
  std::optional<fs::path> cramped;
  for (const fs::path& place : {fs::path("/dev/shm"), temporary_place(), cache_dir}) {
    std::error_code ignored;
    if (place == cache_dir) fs::create_directories(place, ignored);
    const std::string problem = try_file(place, true);
    if (!problem.empty()) {
      problems += fmt::format("{}{}: {}", problems.empty() ? "" : ", ", place.string(), problem);
    } else if (is_roomy(place)) {
      return place;
    } else if (!cramped) {
      cramped = place;
    }
  }
  if (cramped) return *cramped;
  throw_error(
      ErrorClass::device,
      "the OpenCL driver needs a folder that is writable and not mounted noexec ({}); set TMPDIR or --cache-dir "
      "to one",
      problems);
}

}  // namespace

DriverFolder::DriverFolder(const fs::path& cache_dir) : process_(getpid()) {
  const fs::path place = choose_place(cache_dir);
  remove_abandoned(place);
  std::string pattern = (place / (owned_prefix() + "XXXXXX")).string();
  if (!mkdtemp(pattern.data())) {
    throw_error(ErrorClass::device, "cannot create a folder for the OpenCL driver in {}: {}", place.string(),
                reason(errno));
  }
  path_ = pattern;
  // The lock gets its name when it is held, so that the folder never looks abandoned in between.
  const fs::path unlocked = path_ / ".lock";
  lock_ = open(unlocked.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (lock_ >= 0 && flock(lock_, LOCK_EX | LOCK_NB) == 0) rename(unlocked.c_str(), (path_ / lock_name).c_str());
}

DriverFolder::~DriverFolder() {
  if (lock_ >= 0) close(lock_);
  if (getpid() != process_) return;  // a forked child must not remove its parent's files
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

bool DriverFolder::is_one(const fs::path& path) { return path.filename().string().starts_with(name_prefix); }

std::vector<std::string> DriverFolder::programs() const {
  std::vector<std::string> found;
  std::error_code failure;
  for (fs::recursive_directory_iterator entry(path_, failure), end; !failure && entry != end;
       entry.increment(failure)) {
    if (entry->path().filename() != "program.bc") continue;
    found.push_back(entry->path().parent_path().lexically_relative(path_).string());
  }
  return found;
}

std::string why_not_writable(const fs::path& folder) {
  std::error_code failure;
  fs::create_directories(folder, failure);
  return failure ? failure.message() : try_file(folder, false);
}

}  // namespace lucarium
