// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "lucarium/compare/run/comparison.h"

namespace lucarium {

/// Plan of a comparison, for people: scenes, light paths and references, memory, limitations, the runs, and an
/// estimate of the time, for which the first iterations of each variant are rendered: a run ends with its budget, or
/// where the technique says that it will. Writes nothing.
std::string describe_plan(const ComparisonSpec& spec, const TechniqueRegistry& registry,
                          const ComparisonOptions& options);

}  // namespace lucarium
