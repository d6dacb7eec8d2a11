// SPDX-License-Identifier: Apache-2.0
// What OpenCL drivers read from the environment, set before the first OpenCL call of the process.
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <mutex>

#include "lucarium/base/error.h"
#include "lucarium/base/log.h"
#include "lucarium/compute/device.h"
#include "lucarium/compute/program_cache.h"

namespace lucarium {
namespace fs = std::filesystem;
namespace {

std::string environment_value(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

/// PoCL's own cache of this process when no lasting folder can be used; removed at exit.
class TemporaryDriverCache {
 public:
  static fs::path create() {
    static TemporaryDriverCache instance;
    return instance.path_;
  }

 private:
  TemporaryDriverCache() : owner_(getpid()) {
    std::error_code failure;
    const fs::path base = fs::temp_directory_path(failure);
    std::string pattern = ((failure ? fs::path("/tmp") : base) / "lucarium-driver-XXXXXX").string();
    if (!mkdtemp(pattern.data())) {
      throw_error(
          ErrorClass::device,
          "no folder is writable for the OpenCL driver's files, neither the cache nor {}; set LUCARIUM_CACHE_DIR "
          "or TMPDIR to a writable folder",
          fs::path(pattern).parent_path().string());
    }
    path_ = pattern;
  }
  ~TemporaryDriverCache() {
    if (getpid() != owner_) return;  // a forked child must not remove its parent's files
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }

  pid_t owner_;
  fs::path path_;
};

/// PoCL 3.1 fails obscurely on bad cache folders (unwritable: every build fails with an empty log; uncreatable: no
/// devices at all), so the folder is tried out first.
void set_driver_cache(const DeviceOptions& options) {
  const std::string chosen_by_user = environment_value("POCL_CACHE_DIR");
  if (!options.use_cache) {
    setenv("POCL_CACHE_DIR", TemporaryDriverCache::create().c_str(), 1);
    return;
  }
  const fs::path wanted = chosen_by_user.empty() ? resolve_cache_dir(options) / "pocl" : fs::path(chosen_by_user);
  if (const std::string problem = why_not_writable(wanted); !problem.empty()) {
    log_warning("cache folder {} cannot be used ({}); compiled kernels will not be kept. Choose another with {}",
                wanted.string(), problem,
                chosen_by_user.empty() ? "--cache-dir or LUCARIUM_CACHE_DIR" : "POCL_CACHE_DIR");
    setenv("POCL_CACHE_DIR", TemporaryDriverCache::create().c_str(), 1);
    return;
  }
  setenv("POCL_CACHE_DIR", fs::absolute(wanted).c_str(), 1);
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
    set_driver_cache(options);
    set_thread_count(options.threads);
  });
}

fs::path resolve_cache_dir(const DeviceOptions& options) {
  if (!options.cache_dir.empty()) return options.cache_dir;
  if (const std::string dir = environment_value("LUCARIUM_CACHE_DIR"); !dir.empty()) return dir;
  if (const std::string dir = environment_value("XDG_CACHE_HOME"); !dir.empty()) return fs::path(dir) / "lucarium";
  if (const std::string home = environment_value("HOME"); !home.empty()) return fs::path(home) / ".cache/lucarium";
  std::error_code failure;
  const fs::path base = fs::temp_directory_path(failure);
  return (failure ? fs::path("/tmp") : base) / fmt::format("lucarium-cache-{}", getuid());
}

std::string why_not_writable(const fs::path& folder) {
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (failure) return failure.message();
  std::string probe = (folder / ".probe-XXXXXX").string();
  const int file = mkstemp(probe.data());
  if (file < 0) return std::generic_category().message(errno);
  const bool written = write(file, "probe", 5) == 5;
  const int reason = errno;
  close(file);
  unlink(probe.c_str());
  return written ? "" : std::generic_category().message(reason);
}

}  // namespace lucarium
