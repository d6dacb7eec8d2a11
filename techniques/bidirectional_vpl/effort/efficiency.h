// SPDX-License-Identifier: Apache-2.0
// What an iteration costs, and how noisy its image is.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "lucarium/shared/scene_types.h"

namespace lucarium::bidirectional {

/// Work of what `counters` (Technique::counters) count, in shadow rays; `candidates`: of a connection. The shares are
/// fixed, so that a decision is the same on every run.
double work_of(const std::map<std::string, double>& counters, uint32_t candidates);

/// Moments of a trial's image.
struct TrialImage {
  uint32_t samples = 0;
  std::vector<float4> sums, squares;  ///< per pixel, as effort/trial_moments.cl adds them
};

/// Relative variance of a sample: over pixels and channels the mean of variance / (mean² + 0.01 Y²), Y the mean
/// luminance, as relMSE weighs errors. Means are those of `reference`, which has the same pixels and all strategies.
///
/// A trial may have missed light that it finds too rarely. Where it is darker than the reference by more than noise
/// explains, what is missing, T of all pixels and samples, would have come in about one event at most: its square
/// counts, too.
double relative_variance(const TrialImage& trial, const TrialImage& reference);

}  // namespace lucarium::bidirectional
