// SPDX-License-Identifier: Apache-2.0
#include "lucarium/metrics/ssim.h"

#include <array>
#include <cmath>
#include <limits>

namespace lucarium {
namespace {

constexpr size_t window = 11;
constexpr double sigma = 1.5;
constexpr double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;

std::array<double, window> gaussian() {
  std::array<double, window> taps{};
  double sum = 0;
  for (size_t i = 0; i < window; ++i) {
    const double d = static_cast<double>(i) - window / 2;
    sum += taps[i] = std::exp(-d * d / (2 * sigma * sigma));
  }
  for (double& tap : taps) tap /= sum;
  return taps;
}

std::vector<double> product(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> result(a.size());
  for (size_t i = 0; i < a.size(); ++i) result[i] = a[i] * b[i];
  return result;
}

/// Weighted means of all windows inside the image: width − 10 by height − 10. Empty when none fits.
std::vector<double> window_means(const std::vector<double>& image, size_t width, size_t height) {
  if (width < window || height < window) return {};
  static const std::array<double, window> taps = gaussian();
  const size_t out_width = width - window + 1, out_height = height - window + 1;
  std::vector<double> rows(out_width * height), out(out_width * out_height);
  for (size_t y = 0; y < height; ++y) {
    for (size_t k = 0; k < window; ++k) {
      const double tap = taps[k];
      const double* shifted = image.data() + y * width + k;
      double* sums = rows.data() + y * out_width;
      for (size_t x = 0; x < out_width; ++x) sums[x] += tap * shifted[x];
    }
  }
  for (size_t y = 0; y < out_height; ++y) {
    for (size_t k = 0; k < window; ++k) {
      const double tap = taps[k];
      const double* row = rows.data() + (y + k) * out_width;
      double* sums = out.data() + y * out_width;
      for (size_t x = 0; x < out_width; ++x) sums[x] += tap * row[x];
    }
  }
  return out;
}

}  // namespace

SsimReference::SsimReference(uint32_t width, uint32_t height, std::vector<double> values)
    : width_(width), height_(height), values_(std::move(values)) {
  mean_ = window_means(values_, width, height);
  mean_square_ = window_means(product(values_, values_), width, height);
}

double SsimReference::compare(const std::vector<double>& test, const std::vector<bool>& excluded) const {
  const std::vector<double> mean = window_means(test, width_, height_),
                            mean_square = window_means(product(test, test), width_, height_),
                            mean_product = window_means(product(test, values_), width_, height_);
  double sum = 0;
  size_t windows = 0;
  for (size_t i = 0; i < mean.size(); ++i) {
    const size_t out_width = width_ - window + 1, x = i % out_width + window / 2, y = i / out_width + window / 2;
    if (!excluded.empty() && excluded[y * width_ + x]) continue;
    const double a = mean[i], b = mean_[i];
    const double variance_a = mean_square[i] - a * a, variance_b = mean_square_[i] - b * b,
                 covariance = mean_product[i] - a * b;
    sum += (2 * a * b + c1) * (2 * covariance + c2) / ((a * a + b * b + c1) * (variance_a + variance_b + c2));
    ++windows;
  }
  return windows > 0 ? sum / static_cast<double>(windows) : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace lucarium
