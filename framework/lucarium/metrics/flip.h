// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

namespace lucarium {

/// Pixels per degree of a 0.7 m wide display of 3840 pixels seen from 0.7 m.
inline constexpr double flip_pixels_per_degree = 67.0206;

/// How FLIP puts a linear image on a display: times 2^exposure_stops, through the tone curve (HDR-FLIP) or not
/// (LDR-FLIP), clamped to [0,1].
struct FlipView {
  double exposure_stops = 0;
  bool tone_mapped = false;
};

/// The exposures of HDR-FLIP: `count` ≥ 2 equal steps from `start` to `stop` [stops]. Between them the brightest and
/// the median pixel of the reference rise to 0.85 of the display's range.
struct HdrFlipExposures {
  double start = 0, stop = 0;
  uint32_t count = 2;
};

/// Exposures of a linear RGB reference, to be shared by all images compared with it. A median of zero is replaced by
/// the median of the pixels that are not black, and none lies more than 20 stops below the brightest pixel; a black
/// reference has start = stop = 0.
HdrFlipExposures hdr_flip_exposures(const std::vector<float>& reference);
std::vector<FlipView> hdr_flip_views(const HdrFlipExposures& exposures);

/// FLIP, the difference that an observer sees when a reference and a test image alternate.
/// Andersson et al., "FLIP: A Difference Evaluator for Alternating Images", HPG 2020; for several views the greatest of
/// their errors: Andersson et al., "Visualizing Errors in Rendered High Dynamic Range Images", Eurographics 2021.
/// What depends on the reference alone is computed once, up to 512 MiB of it (20 bytes per pixel and view).
class FlipReference {
 public:
  /// `reference`: linear RGB, width · height · 3 finite floats. Throws Error{input} on another size or without a view.
  FlipReference(uint32_t width, uint32_t height, std::vector<float> reference, std::vector<FlipView> views,
                double pixels_per_degree = flip_pixels_per_degree);
  ~FlipReference();
  FlipReference(FlipReference&&) noexcept;
  FlipReference& operator=(FlipReference&&) noexcept;

  /// Error of every pixel in [0,1]; FLIP is its mean. Pixels of `test` that are not finite count as the reference's in
  /// the neighbourhood that the observer sees; their own error is 1. Throws Error{input} on another size.
  std::vector<float> error_map(const std::vector<float>& test) const;

 private:
  struct Prepared;
  std::unique_ptr<Prepared> prepared_;
};

}  // namespace lucarium
