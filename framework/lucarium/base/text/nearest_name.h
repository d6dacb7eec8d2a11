// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace lucarium {

/// The candidate with the smallest edit distance to `name`, or empty if none is near enough to be a likely typo.
std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates);

/// "; did you mean 'x'?" or, when nothing is near, "; known are a, b, c".
std::string suggest_name(std::string_view name, const std::vector<std::string>& candidates);

}  // namespace lucarium
