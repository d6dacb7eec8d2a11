// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "lucarium/scene/import_options.h"

namespace lucarium {

/// Equirectangular .hdr or .exr.
Environment load_environment(const std::filesystem::path& file, const ImportOptions& options = {});

}  // namespace lucarium
