// SPDX-License-Identifier: Apache-2.0
// Time that the technique takes, for parameters, a scene and an image.
#pragma once
#include <vector>

#include "lucarium/technique/technique.h"
#include "micro_rendering/base/micro_parameters.h"

namespace lucarium::micro {

/// Seconds until the first frame has all its gathers (Technique::estimate_seconds).
double estimate_seconds(const MicroParameters& parameters, const Scene& scene, const RenderSettings& settings,
                        const ComputePower& power);

/// Samples of pixels that belong to a frame, so that they are `eye_share` of its work; 1 or more.
uint32_t eye_samples_per_frame(const MicroParameters& parameters, const Scene& scene, const RenderSettings& settings);

/// What may be lowered for a budget: points, gathers for several bounces, micro-buffers; at last pixels.
std::vector<ParameterSaving> savings();

}  // namespace lucarium::micro
