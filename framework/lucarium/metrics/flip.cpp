// SPDX-License-Identifier: Apache-2.0
#include "lucarium/metrics/flip.h"

#include <algorithm>
#include <cmath>

#include "lucarium/base/error.h"
#include "lucarium/base/luminance.h"
#include "lucarium/metrics/flip_vision.h"

namespace lucarium {
namespace {

constexpr size_t kept_bytes = size_t{512} << 20;
constexpr double greatest_range_stops = 20;

// The tone curve (n2 x² + n1 x)/(d2 x² + d1 x + d0): Narkowicz's fit of ACES, scaled.
constexpr double n2 = 0.9036, n1 = 0.018, d2 = 0.8748, d1 = 0.354, d0 = 0.14;
constexpr double reached_value = 0.85;  // what the brightest and the median pixel rise to

float tone_curve(float x) {
  // The curve passes 1 at x = 12; beyond, the squares would overflow.
  x = std::min(x, 100.f);
  return (static_cast<float>(n2) * x * x + static_cast<float>(n1) * x) /
         (static_cast<float>(d2) * x * x + static_cast<float>(d1) * x + static_cast<float>(d0));
}

/// Where the tone curve has the value v: the positive root of (n2 − v d2) x² + (n1 − v d1) x − v d0.
double inverse_tone_curve(double v) {
  const double a = n2 - v * d2, b = n1 - v * d1, c = -v * d0;
  return (-b + std::sqrt(b * b - 4 * a * c)) / (2 * a);
}

std::vector<float> displayed(const std::vector<float>& rgb, const FlipView& view) {
  const auto scale = static_cast<float>(std::exp2(view.exposure_stops));
  std::vector<float> shown(rgb.size());
  std::transform(rgb.begin(), rgb.end(), shown.begin(), [&](float v) {
    const float exposed = std::max(0.f, v * scale);
    return std::min(1.f, view.tone_mapped ? tone_curve(exposed) : exposed);
  });
  return shown;
}

bool finite_pixel(const std::vector<float>& rgb, size_t p) {
  return std::isfinite(rgb[3 * p]) && std::isfinite(rgb[3 * p + 1]) && std::isfinite(rgb[3 * p + 2]);
}

/// The element in the middle; the upper one of two.
float median(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

HdrFlipExposures hdr_flip_exposures(const std::vector<float>& reference) {
  std::vector<float> luminances(reference.size() / 3);
  for (size_t p = 0; p < luminances.size(); ++p)
    luminances[p] = luminance(reference[3 * p], reference[3 * p + 1], reference[3 * p + 2]);
  const float brightest = luminances.empty() ? 0 : *std::max_element(luminances.begin(), luminances.end());
  if (!(brightest > 0)) return {};
  float middle = median(luminances);
  if (!(middle > 0)) {
    luminances.erase(std::remove_if(luminances.begin(), luminances.end(), [](float y) { return !(y > 0); }),
                     luminances.end());
    middle = median(luminances);
  }
  const double range = std::min(greatest_range_stops, std::log2(double{brightest} / middle));
  HdrFlipExposures exposures;
  exposures.start = std::log2(inverse_tone_curve(reached_value) / brightest);
  exposures.stop = exposures.start + range;
  exposures.count = static_cast<uint32_t>(std::max(2.0, std::ceil(range)));
  return exposures;
}

std::vector<FlipView> hdr_flip_views(const HdrFlipExposures& exposures) {
  std::vector<FlipView> views;
  for (uint32_t i = 0; i < exposures.count; ++i) {
    views.push_back({exposures.start + (exposures.stop - exposures.start) * i / (exposures.count - 1.0), true});
  }
  return views;
}

struct FlipReference::Prepared {
  uint32_t width, height;
  std::vector<float> reference;
  std::vector<FlipView> views;
  FlipVision vision;
  std::vector<FlipPercept> percepts;  // of the first views; the others are too large to keep

  FlipPercept perceive(const std::vector<float>& rgb, const FlipView& view) const {
    return vision.perceive(width, height, displayed(rgb, view));
  }
};

FlipReference::FlipReference(uint32_t width, uint32_t height, std::vector<float> reference, std::vector<FlipView> views,
                             double pixels_per_degree)
    : prepared_(
          new Prepared{width, height, std::move(reference), std::move(views), FlipVision(pixels_per_degree), {}}) {
  const size_t pixels = size_t{width} * height;
  if (pixels == 0 || prepared_->reference.size() != 3 * pixels || prepared_->views.empty()) {
    throw_error(ErrorClass::input,
                "FLIP needs a reference of {}×{} RGB pixels and a view; it has {} values and {} views", width, height,
                prepared_->reference.size(), prepared_->views.size());
  }
  const size_t kept = std::min(prepared_->views.size(), kept_bytes / (pixels * 5 * sizeof(float)));
  for (size_t v = 0; v < kept; ++v) {
    prepared_->percepts.push_back(prepared_->perceive(prepared_->reference, prepared_->views[v]));
  }
}

FlipReference::~FlipReference() = default;
FlipReference::FlipReference(FlipReference&&) noexcept = default;
FlipReference& FlipReference::operator=(FlipReference&&) noexcept = default;

std::vector<float> FlipReference::error_map(const std::vector<float>& test) const {
  const Prepared& p = *prepared_;
  if (test.size() != p.reference.size()) {
    throw_error(ErrorClass::input, "images of different size cannot be compared: {} and {} values for {}×{} pixels",
                test.size(), p.reference.size(), p.width, p.height);
  }
  const size_t pixels = test.size() / 3;
  std::vector<float> seen = test;
  std::vector<size_t> nonfinite;
  for (size_t pixel = 0; pixel < pixels; ++pixel) {
    if (finite_pixel(test, pixel)) continue;
    nonfinite.push_back(pixel);
    std::copy_n(p.reference.begin() + static_cast<ptrdiff_t>(3 * pixel), 3,
                seen.begin() + static_cast<ptrdiff_t>(3 * pixel));
  }
  std::vector<float> greatest(pixels, 0.f);
  for (size_t v = 0; v < p.views.size(); ++v) {
    const FlipPercept test_percept = p.perceive(seen, p.views[v]);
    const std::vector<float> error = v < p.percepts.size()
                                         ? flip_error(p.percepts[v], test_percept)
                                         : flip_error(p.perceive(p.reference, p.views[v]), test_percept);
    std::transform(error.begin(), error.end(), greatest.begin(), greatest.begin(),
                   [](float a, float b) { return std::max(a, b); });
  }
  for (const size_t pixel : nonfinite) greatest[pixel] = 1;
  return greatest;
}

}  // namespace lucarium
