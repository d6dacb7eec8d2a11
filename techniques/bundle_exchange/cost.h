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

/// Work of the parts of an iteration [s of one core]: a direction, a run of light samples at texel sides, a sample of
/// all pixels.
struct WorkUnits {
  double direction = 0, light_run = 0, eye_sample = 0;
};
/// `sides`: of all texels; `light_run`: texel sides of a run; `rays`: of chains from all pixels, in a sample.
WorkUnits work_units(uint32_t sides, uint32_t light_run, size_t triangles, uint32_t pixels, double rays);

/// Share of the work that samples of pixels get.
struct EyeShare {
  double share = 0.25;
  bool measured = false;  ///< it follows from variances
  bool due = false;       ///< the image lags behind what texels know
};

/// Camera samples that so many directions and runs of light samples earn: `eye` of all work is theirs, so that what is
/// cheap, direct light and edges, does not wait for what is dear. Where that share is not measured, dear ones get half
/// of it, at most one at a time; where it is, one when it is due. But the share and no more before directions carry
/// light (`lit`): then the picture lacks most of all. Pixels that gather along bundles take one each time, as with
/// eye_share=0.
double earned_eye_samples(const Parameters& parameters, const EyeShare& eye, const WorkUnits& units,
                          uint64_t directions, uint32_t light_runs, bool lit);

/// What may be lowered for a budget: rays that measure accessibility, and texels.
std::vector<ParameterSaving> savings();

}  // namespace lucarium::bundle
