// SPDX-License-Identifier: Apache-2.0
#include "lucarium/check/block_test.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lucarium/check/check_context.h"
#include "lucarium/compare/student_t.h"

namespace lucarium::check {
namespace {

constexpr uint32_t block = 8;

struct Moments {
  double mean = 0, variance_of_mean = 0;
};

Moments moments(const std::vector<double>& values) {
  const double n = static_cast<double>(values.size());
  Moments m;
  for (const double v : values) m.mean += v / n;
  for (const double v : values) m.variance_of_mean += (v - m.mean) * (v - m.mean) / (n - 1) / n;
  return m;
}

/// Mean of one channel over one block, for each image.
std::vector<double> block_means(const std::vector<std::vector<float>>& images, uint32_t width, uint32_t height, uint32_t x0, uint32_t y0,
                                uint32_t channel) {
  std::vector<double> means;
  const uint32_t x1 = std::min(x0 + block, width), y1 = std::min(y0 + block, height);
  for (const std::vector<float>& image : images) {
    double sum = 0;
    for (uint32_t y = y0; y < y1; ++y) {
      for (uint32_t x = x0; x < x1; ++x) sum += image[3 * (size_t{y} * width + x) + channel];
    }
    means.push_back(sum / ((x1 - x0) * (y1 - y0)));
  }
  return means;
}

/// Two-sided p of a difference of means beyond `allowance` (Welch).
double welch_p(const Moments& a, const Moments& b, double n_a, double n_b, double allowance, double& t) {
  const double excess = std::max(0.0, std::abs(a.mean - b.mean) - allowance);
  const double variance = a.variance_of_mean + b.variance_of_mean;
  t = 0;
  if (excess == 0) return 1;
  if (variance == 0) {
    t = INFINITY;
    return 0;
  }
  t = excess / std::sqrt(variance);
  const double dof = variance * variance / (a.variance_of_mean * a.variance_of_mean / (n_a - 1) +
                                            b.variance_of_mean * b.variance_of_mean / (n_b - 1));
  return student_t_tail(t, dof);
}

}  // namespace

BlockTest compare_blocks(const std::vector<std::vector<float>>& a, const std::vector<std::vector<float>>& b, uint32_t width,
                         uint32_t height) {
  BlockTest result;
  double smallest_p = 1, squares = 0, noise = 0, scale = 0;
  for (uint32_t y = 0; y < height; y += block) {
    for (uint32_t x = 0; x < width; x += block) {
      for (uint32_t channel = 0; channel < 3; ++channel) {
        const Moments m = moments(block_means(a, width, height, x, y, channel));
        const Moments n = moments(block_means(b, width, height, x, y, channel));
        double t = 0;
        smallest_p = std::min(smallest_p, welch_p(m, n, static_cast<double>(a.size()), static_cast<double>(b.size()),
                                                  rounding * std::abs(n.mean), t));
        result.largest_t = std::max(result.largest_t, t);
        squares += (m.mean - n.mean) * (m.mean - n.mean);
        noise += m.variance_of_mean + n.variance_of_mean;
        scale += n.mean * n.mean;
        ++result.tests;
      }
    }
  }
  result.p = 1 - std::pow(1 - smallest_p, static_cast<double>(result.tests));
  if (scale > 0) {
    result.rms = std::sqrt(std::max(0.0, squares - noise) / scale);
    result.noise = std::sqrt(noise / scale);
  } else {
    result.rms = squares > 0 ? INFINITY : 0;
  }
  return result;
}

bool BlockTest::passes(double bias) const { return bias > 0 ? rms <= bias : p >= level; }

std::string BlockTest::describe(double bias) const {
  const std::string size = fmt::format("difference {:.2g} % beyond noise of {:.2g} %", 100 * rms, 100 * noise);
  if (bias > 0) return size;
  return fmt::format("p = {:.2g} over {} blocks, worst |t| = {:.1f}; {}", p, tests, largest_t, size);
}

}  // namespace lucarium::check
