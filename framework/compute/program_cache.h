// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

#include "lucarium/compute/device.h"

namespace lucarium {

/// The folder of compiled programs: options.cache_dir, LUCARIUM_CACHE_DIR, XDG_CACHE_HOME/lucarium or
/// ~/.cache/lucarium, whichever is set first. Does not create it.
std::filesystem::path resolve_cache_dir(const DeviceOptions& options);

/// Creates the folder if need be and tries to write a file there; empty when that works, else the reason.
std::string why_not_writable(const std::filesystem::path& folder);

/// Compiled programs on disk.
class ProgramCache {
 public:
  explicit ProgramCache(const DeviceOptions& options);
};

}  // namespace lucarium
