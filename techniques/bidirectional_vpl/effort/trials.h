// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bidirectional_vpl/base/parameters.h"
#include "bidirectional_vpl/effort/efficiency.h"
#include "bidirectional_vpl/effort/small_parts.h"

namespace lucarium::bidirectional {

/// Whether there is something to decide (adapt=on): the modes for few samples, maps and bundles stay as they are, and
/// so does a number of light paths that is given.
bool can_adapt(const BidirectionalParameters& parameters, const Plan& plan);

/// Finds out what light paths, splats, longer light paths and longer camera paths are worth: the least product of a
/// sample's variance and work (after Grittmann et al. 2022, "Efficiency-Aware Multiple Importance Sampling for
/// Bidirectional Rendering Algorithms", who estimate it from the image's samples). It is measured here, with small
/// images, whose samples are none of the image's: those decide nothing about themselves, so that its mean is right.
class Trials {
 public:
  /// `settings`, `frame`: of the image. `kept`: for the next trials of this scene and size; must outlive this.
  Trials(const PartsContext& context, const BidirectionalParameters& parameters, const RenderSettings& settings,
         const Frame& frame, KeptParts& kept);

  /// What renders the trials that are always done; it is kept.
  std::vector<std::shared_ptr<SmallParts>> certain_parts() const;

  /// Does one trial, of some 10 ms to 100 ms. False when cancelled: it is done again then.
  bool advance();
  /// Trials so far.
  size_t done() const { return products_.size(); }
  /// What they took: `trials`, and in total `trial_paths`, camera paths, and `trial_rays`, rays of all kinds.
  const std::map<std::string, double>& counted() const { return counted_; }
  /// What lowers the error most for its work, when all trials are done.
  const std::optional<Effort>& best() const { return decided_; }
  /// Samples of the image before trials: 16, and in small images as many as trials cost.
  static uint64_t samples_before(const BidirectionalParameters& parameters, const RenderSettings& settings);
  /// Settings of the small images.
  static RenderSettings trial_settings(const RenderSettings& settings);
  /// Most device bytes that trials take beside the image.
  static size_t estimate_bytes(const BidirectionalParameters& parameters, const Scene& scene,
                               const RenderSettings& settings);

 private:
  /// The decision, or, where a trial is missing, nothing and which.
  std::optional<Effort> decide(Effort* missing) const;
  /// Variance times work of a trial that is done.
  std::optional<double> product(const Effort& effort) const;
  /// False when cancelled.
  bool render(const Effort& effort);
  std::shared_ptr<SmallParts> small_parts(const Effort& effort) const;

  PartsContext context_;
  BidirectionalParameters parameters_;
  RenderSettings settings_;
  Frame frame_;
  Program program_;
  TrialImage reference_;  ///< of the whole effort, which is tried first
  PixelWeights weights_;
  std::vector<std::pair<Effort, double>> products_;
  std::optional<Effort> decided_;
  KeptParts& kept_;
  std::map<std::string, double> counters_;  ///< of the whole effort's trial
  std::map<std::string, double> counted_;
};

}  // namespace lucarium::bidirectional
