// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

namespace lucarium::app {

/// Finds before any work is done what would make writing `file` fail: a folder of that name, a file that is not to be
/// replaced, a missing or unwritable folder. Throws Error{usage} or Error{input}.
void check_output(const std::filesystem::path& file, bool overwrite);

}  // namespace lucarium::app
