// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <vector>

namespace lucarium {

/// Where plug-ins are looked for, in order, each once: `extra`, LUCARIUM_TECHNIQUE_PATH, and lib/lucarium/techniques
/// relative to the executable and to the framework library. They need not exist.
std::vector<std::filesystem::path> technique_folders(const std::vector<std::filesystem::path>& extra = {});

}  // namespace lucarium
