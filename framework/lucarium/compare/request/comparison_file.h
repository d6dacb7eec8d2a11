// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/base/files/json_file.h"
#include "lucarium/compare/request/comparison_spec.h"

namespace lucarium {

/// Names the form of comparison files (docs/comparisons.md).
inline constexpr const char* comparison_schema = "lucarium-comparison-1";

/// The comparison that the members of an object at `pointer` of a file define. The object may have been changed since
/// it was read: complaints then name the nearest line that is known.
ComparisonSpec read_comparison(const JsonFile& file, const nlohmann::json& object, const std::string& pointer);

}  // namespace lucarium
