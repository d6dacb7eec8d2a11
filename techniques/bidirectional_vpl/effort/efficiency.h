// SPDX-License-Identifier: Apache-2.0
// What an iteration costs, and how noisy its image is.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "lucarium/shared/scene_types.h"

namespace lucarium::bidirectional {

/// Work of what `counters` (Technique::counters) count, in shadow rays. The shares are fixed, so that a decision is the
/// same on every run.
double work_of(const std::map<std::string, double>& counters);

/// A trial's image.
struct TrialImage {
  uint32_t width = 0, height = 0;
  std::vector<std::vector<float4>> sums;  ///< per pixel [cd/m²], after each sample
  std::vector<float4> squares;            ///< per pixel sums of the squares of samples, after the last

  double samples() const { return static_cast<double>(sums.size()); }
};

/// What errors of a pixel count in each channel: 1 / (mean² + 0.01 Y²), Y the mean luminance, as in relMSE. Means are
/// those of the pixels around, so that a pixel's noise does not choose its own weight.
using PixelWeights = std::vector<std::array<double, 3>>;
PixelWeights pixel_weights(const TrialImage& reference);

/// Pixels that have any light.
size_t lit_pixels(const TrialImage& image);

/// Mean over pixels and channels of a sample's weighted variance.
double relative_variance(const TrialImage& trial, const PixelWeights& weights);

/// Variance that a trial has not shown: where it is darker than the reference by more than chance, it has missed light
/// that it finds too rarely. All of it would have come in about one sample of one pixel. Looked for in the whole image
/// and in blocks of several sizes, in which a caustic stands out: the largest of all.
double hidden_variance(const TrialImage& trial, const TrialImage& reference, const PixelWeights& weights);

}  // namespace lucarium::bidirectional
