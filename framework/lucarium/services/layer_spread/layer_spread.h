// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <span>
#include <string>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/services/layer_sums/layer_sums.h"

namespace lucarium {

/// How far the samples of a part of an image scatter, measured while they come in, so that work can go where it lowers
/// the error of the image most. The part's kernel writes sample_deviation() (layer_sums.clh) of each pixel into
/// deviations() when it adds a sample; measure() then takes their mean over the pixels, weighted as in relMSE
/// (docs/metrics.md) with what the image shows. Sums are taken in a fixed order: the same samples give the same bits.
class LayerSpread {
 public:
  /// What an image shows: the sum of the means of these layers, each with a sum and a weight per pixel.
  struct Shown {
    TypedBuffer<float4> emission, direct, indirect;
    TypedBuffer<float4> sky = {};  ///< more of the sums of `indirect`, with its weights; may be empty
  };
  /// `deviations`: one per pixel, of the sample added last [cd²/m⁴]. Shared by several parts, which take turns.
  LayerSpread(Device& device, KernelScheduler& scheduler, const Shown& shown, const TypedBuffer<float>& deviations,
              const std::string& owner);
  LayerSpread(const LayerSpread&) = delete;  // the schedule refers to it
  LayerSpread& operator=(const LayerSpread&) = delete;

  /// To its end, when a part has added a sample to all pixels.
  void measure();
  /// Samples that came: all but the first, from which none deviates.
  uint32_t samples() const { return samples_ > 0 ? samples_ - 1 : 0; }
  /// Mean over the pixels of a sample's variance over r² + 0.01 Y²: r what the pixel shows, Y the image's mean
  /// luminance. 0 before the second sample. Pixels that are not finite are left out.
  double variance() const { return known_ > 0 ? sum_ / known_ : 0; }
  /// Mean over the pixels of the square of what `indirect` shows over the same.
  double indirect_share() const { return indirect_share_; }
  void clear();
  void warm_up() { scheduler_->warm_up(schedule_); }

 private:
  void take(std::span<const std::byte> bytes);

  KernelScheduler* scheduler_;
  Schedule schedule_;
  Variable<float> least_;
  uint32_t samples_ = 0, known_ = 0;
  double sum_ = 0, luminance_ = 0, indirect_share_ = 0;
};

/// How many samples of a cheap part the image should have for each of a dear one, so that its error falls most for all
/// work: numbers of samples go as √(variance / work of a sample). 0 where the cheap part has no variance; never
/// infinite: `largest` at most.
double samples_for_each(double cheap_variance, double cheap_work, double dear_variance, double dear_work,
                        double largest);

/// The same as a share of all work: √(variance · work of a sample) of both parts over their sum. 1 where the other
/// part has no variance, 0 where neither has, or a value is not finite.
double share_of_work(double variance, double work, double other_variance, double other_work);

}  // namespace lucarium
