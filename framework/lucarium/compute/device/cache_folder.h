// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "lucarium/compute/device/device.h"

namespace lucarium {

/// The cache folder: options.cache_dir, LUCARIUM_CACHE_DIR, XDG_CACHE_HOME/lucarium or ~/.cache/lucarium, whichever is
/// set first. Does not create it.
std::filesystem::path resolve_cache_dir(const DeviceOptions& options);

}  // namespace lucarium
