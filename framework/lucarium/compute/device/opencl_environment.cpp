// SPDX-License-Identifier: Apache-2.0
// What OpenCL drivers read from the environment, set before the first OpenCL call of the process. Declared in device.h,
// cache_folder.h and pocl_folder.h.
#include <unistd.h>

#include <cstdlib>
#include <mutex>

#include "lucarium/base/error.h"
#include "lucarium/base/log.h"
#include "lucarium/base/text/text_values.h"
#include "lucarium/compute/device/cache_folder.h"
#include "lucarium/compute/device/device.h"
#include "lucarium/compute/device/pocl_folder.h"

namespace lucarium {
namespace fs = std::filesystem;
namespace {

/// Removed at exit, and null from then on: static objects that outlive it ask whether it is there.
DriverFolder* private_folder = nullptr;

void remove_private_folder() {
  delete private_folder;
  private_folder = nullptr;
}

std::string environment_value(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

/// PoCL looks for its linker in PATH. Without PATH the system's own folders are searched, as a shell does.
void set_path() {
  if (std::getenv("PATH") != nullptr) return;
  std::string path(confstr(_CS_PATH, nullptr, 0), '\0');
  confstr(_CS_PATH, path.data(), path.size());
  setenv("PATH", path.c_str(), 0);
}

void set_driver_folder(const DeviceOptions& options) {
  const std::string chosen = environment_value("POCL_CACHE_DIR");
  if (!chosen.empty() && !DriverFolder::is_one(chosen)) {  // a parent process's folder is not a choice
    const std::string problem = why_not_writable(chosen);
    if (problem.empty()) return;
    log_warning("POCL_CACHE_DIR={} cannot be used ({}); using a temporary folder", chosen, problem);
  }
  private_folder = new DriverFolder(resolve_cache_dir(options));
  std::atexit(remove_private_folder);
  setenv("POCL_CACHE_DIR", private_folder->path().c_str(), 1);
}

void set_thread_count(int threads) {
  if (threads <= 0) return;
  const std::string count = std::to_string(threads);
  setenv("POCL_MAX_PTHREAD_COUNT", count.c_str(), 1);  // up to PoCL 3.1 (Debian 12)
  setenv("POCL_CPU_MAX_CU_COUNT", count.c_str(), 1);   // from PoCL 4.0 on
}

}  // namespace

void prepare_opencl_environment(const DeviceOptions& options) {
  static std::once_flag once;
  std::call_once(once, [&] {
    set_path();
    set_driver_folder(options);
    set_thread_count(options.threads);
  });
}

void require_linker(const DeviceInfo& info) {
  if (!info.is_pocl || info.type != DeviceType::cpu) return;
  const std::string path = environment_value("PATH");
  for (const std::string& folder : split(path, ':')) {
    if (::access((fs::path(folder.empty() ? "." : folder) / "ld").c_str(), X_OK) == 0) return;
  }
  throw_error(ErrorClass::device,
              "{} links kernels with the program ld, which no folder of PATH ({}) holds; add its folder to PATH, or "
              "install the Debian package binutils",
              info.platform, path);
}

const DriverFolder* driver_folder() { return private_folder; }

fs::path resolve_cache_dir(const DeviceOptions& options) {
  if (!options.cache_dir.empty()) return options.cache_dir;
  if (const std::string dir = environment_value("LUCARIUM_CACHE_DIR"); !dir.empty()) return dir;
  if (const std::string dir = environment_value("XDG_CACHE_HOME"); !dir.empty()) return fs::path(dir) / "lucarium";
  if (const std::string home = environment_value("HOME"); !home.empty()) return fs::path(home) / ".cache/lucarium";
  std::error_code failure;
  const fs::path base = fs::temp_directory_path(failure);
  return (failure ? fs::path("/tmp") : base) / fmt::format("lucarium-cache-{}", getuid());
}

}  // namespace lucarium
