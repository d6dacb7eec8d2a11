// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "lucarium/compare/results/comparison_result.h"

namespace lucarium {

/// Ratio of the geometric means of independent positive values, `now` over `then`. One value on a side: no bounds.
ConfidenceInterval welch_ratio(const std::vector<double>& now, const std::vector<double>& then);

/// Compares with the results.json of another folder in relMSE, HDR_FLIP and seconds. Throws Error{input} when it cannot
/// be read.
BaselineComparison compare_with_baseline(const ComparisonResult& result, const std::filesystem::path& folder);

}  // namespace lucarium
