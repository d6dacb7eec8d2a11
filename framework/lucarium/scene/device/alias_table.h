// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "lucarium/shared/scene_types.h"

namespace lucarium {

/// Walker's alias table by Vose's method (IEEE TSE 17(9), 1991): column i is kept with `probability`, else `alias` is
/// taken; both columns' chances sum up to pmf ∝ weights. Weights must not be negative; if all are 0 the distribution
/// is uniform.
std::vector<AliasEntry> make_alias_table(const std::vector<double>& weights);

}  // namespace lucarium
