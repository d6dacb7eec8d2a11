// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

namespace lucarium {

/// What to do about a file that is not there: "; did you mean 'a.exr'?" for a likely typo, "; there is no folder 'b'",
/// or empty.
std::string advice_for_missing(const std::filesystem::path& file);

}  // namespace lucarium
