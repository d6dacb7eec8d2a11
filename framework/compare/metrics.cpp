// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/metrics.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "lucarium/base/error.h"

namespace lucarium {
namespace {

constexpr int ssim_window = 11;
constexpr double ssim_sigma = 1.5;

double srgb(double linear) {
  const double x = std::clamp(linear, 0.0, 1.0);
  return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
}

std::vector<double> to_srgb(const std::vector<float>& rgb, float exposure_stops) {
  const double scale = std::exp2(exposure_stops);
  std::vector<double> encoded(rgb.size());
  std::transform(rgb.begin(), rgb.end(), encoded.begin(), [scale](float v) { return srgb(std::isfinite(v) ? v * scale : 0); });
  return encoded;
}

double psnr_of(const std::vector<double>& a, const std::vector<double>& b) {
  double mse = 0;
  for (size_t i = 0; i < a.size(); ++i) mse += (a[i] - b[i]) * (a[i] - b[i]);
  return -10 * std::log10(mse / static_cast<double>(a.size()));
}

/// Separable Gaussian over the valid region: width − 10 by height − 10.
std::vector<double> blur(const std::vector<double>& image, size_t width, size_t height) {
  std::array<double, ssim_window> taps{};
  double sum = 0;
  for (int i = 0; i < ssim_window; ++i) {
    const double d = i - ssim_window / 2;
    sum += taps[static_cast<size_t>(i)] = std::exp(-d * d / (2 * ssim_sigma * ssim_sigma));
  }
  for (double& tap : taps) tap /= sum;
  const size_t out_width = width - ssim_window + 1, out_height = height - ssim_window + 1;
  std::vector<double> rows(out_width * height), out(out_width * out_height);
  for (size_t y = 0; y < height; ++y) {
    for (size_t x = 0; x < out_width; ++x) {
      for (size_t k = 0; k < taps.size(); ++k) rows[y * out_width + x] += taps[k] * image[y * width + x + k];
    }
  }
  for (size_t y = 0; y < out_height; ++y) {
    for (size_t x = 0; x < out_width; ++x) {
      for (size_t k = 0; k < taps.size(); ++k) out[y * out_width + x] += taps[k] * rows[(y + k) * out_width + x];
    }
  }
  return out;
}

double ssim_of(const std::vector<double>& a_rgb, const std::vector<double>& b_rgb, size_t width, size_t height) {
  if (width < ssim_window || height < ssim_window) return 0;
  const size_t pixels = width * height;
  std::vector<double> a(pixels), b(pixels), aa(pixels), bb(pixels), ab(pixels);
  for (size_t p = 0; p < pixels; ++p) {
    a[p] = 0.2126 * a_rgb[3 * p] + 0.7152 * a_rgb[3 * p + 1] + 0.0722 * a_rgb[3 * p + 2];
    b[p] = 0.2126 * b_rgb[3 * p] + 0.7152 * b_rgb[3 * p + 1] + 0.0722 * b_rgb[3 * p + 2];
    aa[p] = a[p] * a[p];
    bb[p] = b[p] * b[p];
    ab[p] = a[p] * b[p];
  }
  const auto mean_a = blur(a, width, height), mean_b = blur(b, width, height), mean_aa = blur(aa, width, height),
             mean_bb = blur(bb, width, height), mean_ab = blur(ab, width, height);
  constexpr double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
  double sum = 0;
  for (size_t p = 0; p < mean_a.size(); ++p) {
    const double ma = mean_a[p], mb = mean_b[p];
    const double var_a = mean_aa[p] - ma * ma, var_b = mean_bb[p] - mb * mb, cov = mean_ab[p] - ma * mb;
    sum += (2 * ma * mb + c1) * (2 * cov + c2) / ((ma * ma + mb * mb + c1) * (var_a + var_b + c2));
  }
  return sum / static_cast<double>(mean_a.size());
}

void check_sizes(uint32_t width, uint32_t height, const std::vector<float>& test, const std::vector<float>& reference) {
  const size_t expected = size_t{width} * height * 3;
  if (expected == 0 || test.size() != expected || reference.size() != expected) {
    throw_error(ErrorClass::input, "images of different size cannot be compared: {} and {} values for {}×{} pixels",
                test.size(), reference.size(), width, height);
  }
  if (!std::all_of(reference.begin(), reference.end(), [](float v) { return std::isfinite(v); })) {
    throw_error(ErrorClass::input, "the reference has non-finite pixels and cannot be compared with");
  }
}

}  // namespace

double mean_luminance(const std::vector<float>& rgb) {
  double sum = 0;
  for (size_t i = 0; i + 2 < rgb.size(); i += 3) sum += 0.2126 * rgb[i] + 0.7152 * rgb[i + 1] + 0.0722 * rgb[i + 2];
  return rgb.empty() ? 0 : sum / static_cast<double>(rgb.size() / 3);
}

ImageMetrics compute_metrics(uint32_t width, uint32_t height, const std::vector<float>& test,
                             const std::vector<float>& reference, float exposure_stops) {
  check_sizes(width, height, test, reference);
  const double luminance = mean_luminance(reference);
  // A black reference has no scale of its own; 1e-12 keeps the quotients defined.
  const double floor = 0.01 * luminance + 1e-12, floor2 = 0.01 * luminance * luminance + 1e-24;
  ImageMetrics m;
  std::vector<double> pixel_relmse;
  pixel_relmse.reserve(reference.size() / 3);
  for (size_t p = 0; p < reference.size() / 3; ++p) {
    if (!std::isfinite(test[3 * p]) || !std::isfinite(test[3 * p + 1]) || !std::isfinite(test[3 * p + 2])) {
      ++m.nonfinite;
      continue;
    }
    double relative = 0;
    for (size_t c = 0; c < 3; ++c) {
      const double x = test[3 * p + c], r = reference[3 * p + c], difference = x - r;
      m.mse += difference * difference;
      relative += difference * difference / (r * r + floor2);
      m.mape += std::abs(difference) / (std::abs(r) + floor);
      m.smape += 2 * std::abs(difference) / (std::abs(x) + std::abs(r) + floor);
      m.mean_test += x;
      m.mean_reference += r;
    }
    pixel_relmse.push_back(relative / 3);
  }
  if (pixel_relmse.empty()) throw_error(ErrorClass::input, "no pixel of the image is finite");
  const double values = 3.0 * static_cast<double>(pixel_relmse.size());
  for (double* sum : {&m.mse, &m.mape, &m.smape, &m.mean_test, &m.mean_reference}) *sum /= values;
  m.rmse = std::sqrt(m.mse);
  std::sort(pixel_relmse.begin(), pixel_relmse.end());
  const size_t kept = pixel_relmse.size() - pixel_relmse.size() / 1000;
  for (size_t i = 0; i < pixel_relmse.size(); ++i) {
    m.relmse += pixel_relmse[i];
    if (i < kept) m.relmse_trimmed += pixel_relmse[i];
  }
  m.relmse /= static_cast<double>(pixel_relmse.size());
  m.relmse_trimmed /= static_cast<double>(kept);
  const std::vector<double> a = to_srgb(test, exposure_stops), b = to_srgb(reference, exposure_stops);
  m.psnr = psnr_of(a, b);
  m.ssim = ssim_of(a, b, width, height);
  return m;
}

const std::vector<std::pair<std::string, std::string>>& metric_formulas() {
  static const std::vector<std::pair<std::string, std::string>> formulas = {
      {"MSE", "mean((x-r)^2)"},
      {"RMSE", "sqrt(MSE)"},
      {"relMSE", "mean((x-r)^2 / (r^2 + 0.01 Y^2)), Y the reference's mean luminance"},
      {"relMSE_trimmed", "relMSE without the largest 0.1 % of pixels"},
      {"MAPE", "mean(|x-r| / (|r| + 0.01 Y))"},
      {"SMAPE", "mean(2|x-r| / (|x| + |r| + 0.01 Y))"},
      {"PSNR", "-10 log10 MSE of clamped sRGB at the stated exposure [dB]"},
      {"SSIM", "luminance of clamped sRGB, 11x11 Gaussian sigma 1.5, K = .01, .03, valid region"}};
  return formulas;
}

double metric_value(const ImageMetrics& m, const std::string& name) {
  const std::vector<std::pair<std::string, double>> values = {
      {"MSE", m.mse},   {"RMSE", m.rmse},   {"relMSE", m.relmse}, {"relMSE_trimmed", m.relmse_trimmed},
      {"MAPE", m.mape}, {"SMAPE", m.smape}, {"PSNR", m.psnr},     {"SSIM", m.ssim}};
  for (const auto& [known, value] : values) {
    if (known == name) return value;
  }
  throw_error(ErrorClass::internal, "no metric is called {}", name);
}

}  // namespace lucarium
