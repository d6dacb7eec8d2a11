// SPDX-License-Identifier: Apache-2.0
// Time that the technique takes, for parameters, a scene and an image.
#pragma once
#include <vector>

#include "bundle_exchange/base/parameters.h"
#include "bundle_exchange/bundle_plan.h"
#include "lucarium/technique/technique.h"

namespace lucarium::bundle {

/// Seconds until texels have received light from a few dozen directions (Technique::estimate_seconds).
double estimate_seconds(const BundlePlan& plan, const Parameters& parameters, const Scene& scene,
                        const RenderSettings& settings, const ComputePower& power);

/// What may be lowered for a budget: rays that measure accessibility, and texels.
std::vector<ParameterSaving> savings();

}  // namespace lucarium::bundle
