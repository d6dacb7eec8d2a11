// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "lucarium/compare/comparison.h"

namespace lucarium {

/// What a comparison would do, for people: scenes, light paths and references, memory, limitations, the runs, and an
/// estimate of the time, for which one iteration of each variant is rendered. Writes nothing.
std::string describe_plan(const ComparisonSpec& spec, const TechniqueRegistry& registry, const ComparisonOptions& options);

}  // namespace lucarium
