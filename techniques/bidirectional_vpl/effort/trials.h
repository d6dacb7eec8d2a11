// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>

#include "bidirectional_vpl/base/parameters.h"
#include "bidirectional_vpl/effort/efficiency.h"
#include "bidirectional_vpl/iteration/parts.h"

namespace lucarium::bidirectional {

/// Whether there is something to decide (adapt=on): the modes for few samples, maps and bundles stay as they are.
bool can_adapt(const BidirectionalParameters& parameters, const Plan& plan);

/// Finds out what light paths, splats, longer light paths and longer camera paths are worth (Grittmann et al. 2022,
/// "Efficiency-Aware Multiple Importance Sampling for Bidirectional Rendering Algorithms": the least product of second
/// moment and cost). They are measured here, with small images, whose samples are none of the image's: those decide
/// nothing about themselves, so that its mean is right.
class Trials {
 public:
  /// `settings`, `frame`: of the image.
  Trials(const PartsContext& context, const BidirectionalParameters& parameters, const RenderSettings& settings,
         const Frame& frame);

  /// What lowers the error most for its work. Nothing when cancelled.
  std::optional<Effort> best();
  /// Settings of the small images.
  static RenderSettings trial_settings(const RenderSettings& settings);
  /// Most device bytes that trials take beside the image.
  static size_t estimate_bytes(const BidirectionalParameters& parameters, const Scene& scene,
                               const RenderSettings& settings);

 private:
  /// Takes `effort` where it is better by more than chance. False when cancelled.
  bool try_effort(const Effort& effort);
  std::optional<TrialImage> render(const Plan& plan, double* work) const;

  PartsContext context_;
  BidirectionalParameters parameters_;
  RenderSettings settings_;
  Frame frame_;
  Program program_;
  TrialImage reference_;  ///< of the whole effort, which is measured first
  Effort best_;
  double least_ = 0;  ///< product of the best
};

}  // namespace lucarium::bidirectional
