// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <vector>

namespace lucarium {

/// The folders of LUCARIUM_KERNEL_PATH, in which files by virtual name win over the embedded ones. Warns of what is no
/// folder.
std::vector<std::filesystem::path> kernel_path_roots();

}  // namespace lucarium
