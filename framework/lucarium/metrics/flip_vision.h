// SPDX-License-Identifier: Apache-2.0
// What an observer perceives of one image, after Andersson et al. 2020: colours filtered by the eye's contrast
// sensitivity, edges and points.
#pragma once
#include <cstdint>
#include <vector>

namespace lucarium {

/// One float per pixel and name, rows from the top.
struct FlipPercept {
  std::vector<float> lightness, hunt_a, hunt_b;  ///< filtered colour: L*, and a*, b* times 0.01 L* (Hunt effect)
  std::vector<float> edge, point;                ///< gradient magnitudes of the unfiltered lightness axis Y
};

/// The filters for one display.
class FlipVision {
 public:
  explicit FlipVision(double pixels_per_degree);
  /// `rgb`: linear, in [0,1], width · height · 3.
  FlipPercept perceive(uint32_t width, uint32_t height, const std::vector<float>& rgb) const;

 private:
  using Taps = std::vector<float>;  // 2 · radius + 1, the middle one at the pixel
  Taps achromatic_, red_green_, blue_yellow_[2];
  float blue_yellow_weight_[2] = {0, 0};
  Taps smooth_, first_derivative_, second_derivative_;
};

/// Error in [0,1] of every pixel between two percepts of the same size.
std::vector<float> flip_error(const FlipPercept& reference, const FlipPercept& test);

}  // namespace lucarium
