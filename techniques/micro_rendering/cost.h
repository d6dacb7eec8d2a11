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

/// Work of a part of a frame, counted in seconds of the model: never timed, so that the same seed gives the same bits.
struct FrameWork {
  double eye = 0;       ///< of a sample of all pixels: emission and direct light
  double indirect = 0;  ///< light at points and gathers
};

/// `visits`: nodes that the gathers of a frame have opened, where that is known; else by the model.
FrameWork frame_work(const MicroParameters& parameters, const Scene& scene, const RenderSettings& settings,
                     double visits = 0);

constexpr uint32_t kMaxEyeSamples = 64;  // of a frame, and of each on average

/// Samples of pixels that belong to a frame, so that they are `eye_share` of its work, which is given; 1 or more.
uint32_t eye_samples_per_frame(const MicroParameters& parameters, const Scene& scene, const RenderSettings& settings);

/// The variance, relative to the light that is gathered, that a frame of gathers is taken to have before it is known.
double assumed_gather_variance(const MicroParameters& parameters);

/// What may be lowered for a budget: the cut, half of the points, gathers for several bounces, micro-buffers, pixels
/// that gather; at last more of all but the cut.
std::vector<ParameterSaving> savings();

}  // namespace lucarium::micro
