// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <vector>

namespace lucarium::app {

/// Images are written as .exr or .png. Throws Error{usage} for other names.
void check_image_name(const std::filesystem::path& file);

/// Finds before any work is done what would make writing `file` fail: a folder of that name, a file that is not to be
/// replaced, a missing or unwritable folder. Throws Error{usage}, or
/// Error{input} where the folder is there and cannot be written into.
void check_output(const std::filesystem::path& file, bool overwrite);

/// Throws Error{usage} where two outputs are one file, by whatever names: the later would replace the earlier.
void check_distinct(const std::vector<std::filesystem::path>& files);

}  // namespace lucarium::app
