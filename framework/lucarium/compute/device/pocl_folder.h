// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace lucarium {

struct DeviceInfo;

/// The folder into which PoCL writes what it compiles, private to this process and gone when it ends.
///
/// PoCL trusts its cache folder: a truncated or damaged file there ends the process (assertion or SIGBUS in 3.1), and
/// an unwritable folder fails every build without a reason. So nothing in it outlives a process; what is worth keeping
/// goes through ProgramCache, which verifies it before the driver sees it.
///
/// Preferred place: a file system in memory (PoCL synchronises every file to disk, 0.5 ms each on an SSD), then
/// TMPDIR, then the cache folder; it must be writable, allow executable mappings (PoCL loads its code with dlopen),
/// and have room, since PoCL ends the process when the disk is full. Throws Error{device} when no place will do.
class DriverFolder {
 public:
  explicit DriverFolder(const std::filesystem::path& cache_dir);
  ~DriverFolder();
  DriverFolder(const DriverFolder&) = delete;
  DriverFolder& operator=(const DriverFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

  /// A process that holds it keeps the folder from being taken for an abandoned one.
  int lock() const { return lock_; }

  /// Whether a path looks like a folder of this class, of whichever process.
  static bool is_one(const std::filesystem::path& path);

  /// Folders of built programs, relative to path().
  std::vector<std::string> programs() const;

 private:
  std::filesystem::path path_;
  int lock_ = -1;  ///< held while this process lives, so that others recognize abandoned folders
  int process_ = 0;
};

/// The folder in use; null when the user's own POCL_CACHE_DIR is, or before prepare_opencl_environment().
const DriverFolder* driver_folder();

/// Throws Error{device} where PoCL would end the process at the first launch: without its linker. Call it after
/// prepare_opencl_environment().
void require_linker(const DeviceInfo& info);

/// Creates the folder if need be and tries to write a file there; empty when that works, else the reason.
std::string why_not_writable(const std::filesystem::path& folder);

}  // namespace lucarium
