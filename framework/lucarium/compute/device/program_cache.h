// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lucarium/base/hash.h"
#include "lucarium/compute/device/device.h"
#include "lucarium/compute/device/kernel_signature.h"

namespace lucarium {

/// One file that the driver made for a program, below the driver's folder.
struct DriverFile {
  std::string path;
  std::string bytes;
};

/// Everything needed to have a program again without compiling.
struct CachedProgram {
  std::string binary;                       ///< for clCreateProgramWithBinary; PoCL: empty until every kernel ran once
  std::vector<KernelSignature> signatures;  ///< so that the driver need not be asked
  std::string driver_program;               ///< PoCL: the program's folder below the driver's folder; else empty
  std::vector<DriverFile> driver_files;     ///< PoCL: what it compiled, at the build and at first launches
};

/// Compiled programs on disk, one file each. A file holds magic, length, checksum and content and is written to a
/// temporary first; a damaged or foreign file is ignored, removed and written again. No failure here is ever fatal, and
/// any number of processes may use the folder at once.
class ProgramCache {
 public:
  ProgramCache(const DeviceOptions& options, const DeviceInfo& device);

  /// False when caching is off, or when the user's own POCL_CACHE_DIR keeps what PoCL compiles.
  bool enabled() const { return enabled_; }

  /// 128 bits over source, options, device, driver, platform and framework version.
  Hash128 key(const std::string& source, const std::string& options) const;

  std::optional<CachedProgram> load(const Hash128& key) const;
  void store(const Hash128& key, const CachedProgram& program) const noexcept;
  /// Forgets an entry that the driver refuses.
  void discard(const Hash128& key) const noexcept;

  std::filesystem::path file_of(const Hash128& key) const;

 private:
  void remove_oldest() const;

  std::filesystem::path folder_;
  std::string device_identity_;
  bool enabled_ = false, writable_ = false;
};

}  // namespace lucarium
