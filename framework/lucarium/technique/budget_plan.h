// SPDX-License-Identifier: Apache-2.0
// Values for parameters that the user has not set, so that a budget of time ends in a picture and none of it is left.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "lucarium/technique/technique.h"

namespace lucarium {

/// How long rendering may take.
struct TimeBudget {
  double seconds = 0;       ///< of upload, preparing and iterating; 0: as long as it takes
  bool to_the_end = false;  ///< more accuracy is wanted than what a technique ends with by itself
};

/// What was chosen for a budget, and why.
struct BudgetPlan {
  struct Change {
    std::string parameter, from, to;
  };
  double budget_seconds = 0;      ///< 0: no budget, nothing planned
  double default_seconds = 0;     ///< until the first whole picture, without the changes
  double expected_seconds = 0;    ///< the same with them
  double sufficient_seconds = 0;  ///< a budget for which the cheapest parameters are enough
  std::vector<Change> changes;    ///< each parameter once
  std::vector<Change> lifted;     ///< limits of Technique::endless()
  bool fits() const { return expected_seconds <= budget_seconds; }  ///< there will be a picture
  std::string changes_text() const;  ///< "points_log2 18 -> 15, micro_size 24 -> 16"; empty: nothing was changed
};

/// Plans for `time` and sets the parameters of `technique`, on which `given` are already set: what is given there, or
/// by a preset in it, stays. The first whole picture is to take half of the budget at most; the other half is for more
/// samples, and for machines that are busy. With less time no parameter gets a larger value. Limits are lifted all
/// together, or none where one is given. Depends on the arguments alone, never on a clock.
BudgetPlan plan_budget(Technique& technique, const std::vector<std::pair<std::string, std::string>>& given,
                       const Scene& scene, const RenderSettings& settings, const ComputePower& power,
                       const TimeBudget& time);

}  // namespace lucarium
