// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "lucarium/technique/cost.h"
#include "virtual_light_field/base/plan.h"

namespace lucarium::vlf {

/// Seconds until the first picture with all its light, as Technique::estimate_seconds().
double estimate_seconds(const Plan& plan, const Parameters& parameters, const Scene& scene,
                        const RenderSettings& settings, const ComputePower& power);

/// Technique::savings().
std::vector<ParameterSaving> savings();

/// Device memory [bytes]. How many surfaces keep radiance by direction is taken from the materials; the field refuses
/// with the exact number when it is built.
size_t estimate_bytes(const Plan& plan, const Parameters& parameters, const Scene& scene,
                      const RenderSettings& settings);

}  // namespace lucarium::vlf
