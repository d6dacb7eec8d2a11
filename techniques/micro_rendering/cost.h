// SPDX-License-Identifier: Apache-2.0
// Time that the technique takes, for parameters, a scene and an image.
#pragma once
#include <vector>

#include "lucarium/technique/technique.h"
#include "micro_rendering/base/micro_parameters.h"

namespace lucarium::micro {

/// Seconds until the end of the first frame (Technique::estimate_seconds).
double estimate_seconds(const MicroParameters& parameters, const Scene& scene, const RenderSettings& settings,
                        const ComputePower& power);

/// What may be lowered for a budget: points, gathers for several bounces, micro-buffers; at last pixels.
std::vector<ParameterSaving> savings();

}  // namespace lucarium::micro
