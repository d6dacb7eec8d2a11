// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "lucarium/compare/results/comparison_result.h"

namespace lucarium {

/// Which variant is best on one scene within one budget.
struct Winner {
  size_t scene = 0, budget = 0;
  size_t best = 0, next = 0;  ///< variants: the best, and the best of the others
  std::string metric;         ///< relMSE; with a budget of relMSE: seconds
  ConfidenceInterval ratio;   ///< that of the next over that of the best, paired by seeds
  bool resolved = true;       ///< the reference's own error is small beside both relMSEs
  bool difference_shown() const { return ratio.seeds > 1 && ratio.low > 1; }
};

/// Of every scene and budget in which at least two variants have a result; none where the machines were unlike and time
/// decides (docs/report.md).
std::vector<Winner> find_winners(const ComparisonResult& result);

/// For people: a line for each; empty where nobody can win.
std::string describe_winners(const ComparisonResult& result);

}  // namespace lucarium
