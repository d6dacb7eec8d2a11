// SPDX-License-Identifier: Apache-2.0
#include "lucarium/metrics/metrics.h"

#include <strings.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "lucarium/base/error.h"
#include "lucarium/base/luminance.h"
#include "lucarium/base/numbers.h"
#include "lucarium/base/srgb.h"
#include "lucarium/metrics/ssim.h"

namespace lucarium {
namespace {

/// An image as PSNR and SSIM see it. Values that are not finite are 0.
struct Encoded {
  std::vector<double> srgb, luminance;
};

Encoded encode(const std::vector<float>& rgb, float exposure_stops) {
  const double scale = std::exp2(exposure_stops);
  Encoded encoded;
  encoded.srgb.resize(rgb.size());
  std::transform(rgb.begin(), rgb.end(), encoded.srgb.begin(),
                 [scale](float v) { return std::isfinite(v) ? srgb_from_linear(std::clamp(v * scale, 0.0, 1.0)) : 0; });
  encoded.luminance.resize(rgb.size() / 3);
  for (size_t p = 0; p < encoded.luminance.size(); ++p) {
    const double* c = encoded.srgb.data() + 3 * p;
    encoded.luminance[p] = luminance(c[0], c[1], c[2]);
  }
  return encoded;
}

std::vector<bool> nonfinite_pixels(const std::vector<float>& rgb) {
  std::vector<bool> bad(rgb.size() / 3);
  for (size_t p = 0; p < bad.size(); ++p) {
    bad[p] = !std::isfinite(rgb[3 * p]) || !std::isfinite(rgb[3 * p + 1]) || !std::isfinite(rgb[3 * p + 2]);
  }
  return bad;
}

/// Mean over the pixels that are not excluded of a map with `channels` values per pixel.
template <typename Value>
double mean_without(const std::vector<bool>& excluded, size_t channels, const Value& value) {
  double sum = 0;
  size_t count = 0;
  for (size_t p = 0; p < excluded.size(); ++p) {
    if (excluded[p]) continue;
    for (size_t c = 0; c < channels; ++c) sum += value(channels * p + c);
    count += channels;
  }
  return sum / static_cast<double>(count);
}

/// The metrics that are averages of a function of x and r alone.
void measure_differences(const std::vector<float>& test, const std::vector<float>& reference,
                         const std::vector<bool>& excluded, ImageMetrics& m) {
  const double luminance = mean_luminance(reference);
  // A black reference has no scale of its own; 1e-12 keeps the quotients defined.
  const double floor = 0.01 * luminance + 1e-12, floor2 = 0.01 * luminance * luminance + 1e-24;
  std::vector<double> pixel_relmse;
  pixel_relmse.reserve(excluded.size());
  for (size_t p = 0; p < excluded.size(); ++p) {
    if (excluded[p]) continue;
    double relative = 0;
    for (size_t i = 3 * p; i < 3 * p + 3; ++i) {
      const double x = test[i], r = reference[i], difference = x - r;
      m.mse += difference * difference;
      relative += difference * difference / (r * r + floor2);
      m.mape += std::abs(difference) / (std::abs(r) + floor);
      m.smape += 2 * std::abs(difference) / (std::abs(x) + std::abs(r) + floor);
      m.mean_test += x;
      m.mean_reference += r;
    }
    pixel_relmse.push_back(relative / 3);
  }
  const double values = 3.0 * static_cast<double>(pixel_relmse.size());
  for (double* sum : {&m.mse, &m.mape, &m.smape, &m.mean_test, &m.mean_reference}) *sum /= values;
  m.rmse = std::sqrt(m.mse);

  const size_t kept = pixel_relmse.size() - pixel_relmse.size() / 1000;
  std::nth_element(pixel_relmse.begin(), pixel_relmse.begin() + static_cast<ptrdiff_t>(kept) - 1, pixel_relmse.end());
  for (size_t i = 0; i < pixel_relmse.size(); ++i) {
    m.relmse += pixel_relmse[i];
    if (i < kept) m.relmse_trimmed += pixel_relmse[i];
  }
  m.relmse /= static_cast<double>(pixel_relmse.size());
  m.relmse_trimmed /= static_cast<double>(kept);
}

}  // namespace

struct MetricReference::Prepared {
  uint32_t width, height;
  std::vector<float> reference;
  MetricOptions options;
  Encoded encoded;
  SsimReference ssim;
  HdrFlipExposures exposures;
  std::vector<FlipReference> flip;  // LDR, HDR; empty when not asked for

  std::vector<float> flip_map(size_t index, const std::vector<float>& test) const {
    if (flip.empty()) throw_error(ErrorClass::internal, "this reference was prepared without FLIP");
    return flip[index].error_map(test);
  }

  /// Those of measure_differences(). `excluded` gets the pixels that are not finite.
  ImageMetrics differences(const std::vector<float>& test, std::vector<bool>& excluded) const {
    if (test.size() != reference.size()) {
      throw_error(ErrorClass::input, "images of different size cannot be compared: {} and {} values for {}×{} pixels",
                  test.size(), reference.size(), width, height);
    }
    excluded = nonfinite_pixels(test);
    ImageMetrics m;
    m.nonfinite = static_cast<uint64_t>(std::count(excluded.begin(), excluded.end(), true));
    if (m.nonfinite == excluded.size()) throw_error(ErrorClass::input, "no pixel of the image is finite");
    measure_differences(test, reference, excluded, m);
    return m;
  }
};

MetricReference::MetricReference(uint32_t width, uint32_t height, std::vector<float> reference,
                                 const MetricOptions& options) {
  const size_t expected = size_t{width} * height * 3;
  if (expected == 0 || reference.size() != expected) {
    throw_error(ErrorClass::input, "a reference of {}×{} RGB pixels has {} values, not {}", width, height,
                reference.size(), expected);
  }
  if (!std::all_of(reference.begin(), reference.end(), [](float v) { return std::isfinite(v); })) {
    throw_error(ErrorClass::input, "the reference has non-finite pixels and cannot be compared with");
  }
  Encoded encoded = encode(reference, options.exposure_stops);
  SsimReference ssim(width, height, encoded.luminance);
  const HdrFlipExposures exposures = hdr_flip_exposures(reference);
  std::vector<FlipReference> flip;
  if (options.flip) {
    flip.emplace_back(width, height, reference, std::vector<FlipView>{{options.exposure_stops, false}});
    flip.emplace_back(width, height, reference, hdr_flip_views(exposures));
  }
  prepared_.reset(new Prepared{width, height, std::move(reference), options, std::move(encoded), std::move(ssim),
                               exposures, std::move(flip)});
}

MetricReference::~MetricReference() = default;
MetricReference::MetricReference(MetricReference&&) noexcept = default;
MetricReference& MetricReference::operator=(MetricReference&&) noexcept = default;

std::vector<float> MetricReference::ldr_flip_map(const std::vector<float>& test) const {
  return prepared_->flip_map(0, test);
}

std::vector<float> MetricReference::hdr_flip_map(const std::vector<float>& test) const {
  return prepared_->flip_map(1, test);
}

const HdrFlipExposures& MetricReference::hdr_exposures() const { return prepared_->exposures; }

double MetricReference::relmse(const std::vector<float>& test) const {
  std::vector<bool> excluded;
  return prepared_->differences(test, excluded).relmse;
}

ImageMetrics MetricReference::measure(const std::vector<float>& test) const {
  const Prepared& p = *prepared_;
  std::vector<bool> excluded;
  ImageMetrics m = p.differences(test, excluded);

  Encoded encoded = encode(test, p.options.exposure_stops);
  m.psnr = -10 * std::log10(mean_without(excluded, 3, [&](size_t i) {
    const double difference = encoded.srgb[i] - p.encoded.srgb[i];
    return difference * difference;
  }));
  // In the windows of its neighbours, a pixel that is not finite counts as the reference's.
  for (size_t i = 0; i < excluded.size(); ++i) {
    if (excluded[i]) encoded.luminance[i] = p.encoded.luminance[i];
  }
  m.ssim = p.ssim.compare(encoded.luminance, excluded);

  m.ldr_flip = m.hdr_flip = not_a_number;
  if (p.options.flip) {
    double* const means[] = {&m.ldr_flip, &m.hdr_flip};
    for (size_t i = 0; i < p.flip.size(); ++i) {
      const std::vector<float> map = p.flip[i].error_map(test);
      *means[i] = mean_without(excluded, 1, [&](size_t pixel) { return double{map[pixel]}; });
    }
  }
  return m;
}

ImageMetrics compute_metrics(uint32_t width, uint32_t height, const std::vector<float>& test,
                             const std::vector<float>& reference, float exposure_stops) {
  return MetricReference(width, height, reference, {exposure_stops}).measure(test);
}

double mean_luminance(const std::vector<float>& rgb) {
  double sum = 0;
  for (size_t i = 0; i + 2 < rgb.size(); i += 3) sum += luminance<double>(rgb[i], rgb[i + 1], rgb[i + 2]);
  return rgb.empty() ? 0 : sum / static_cast<double>(rgb.size() / 3);
}

const std::vector<Metric>& metric_table() {
  static const std::vector<Metric> table = {
      {"MSE", "mean((x-r)^2)", "(cd/m^2)^2", true, &ImageMetrics::mse},
      {"RMSE", "sqrt(MSE)", "cd/m^2", true, &ImageMetrics::rmse},
      {"relMSE", "mean((x-r)^2 / (r^2 + 0.01 Y^2)), Y the reference's mean luminance", "", true, &ImageMetrics::relmse},
      {"relMSE_trimmed", "relMSE without the largest 0.1 % of pixels", "", true, &ImageMetrics::relmse_trimmed},
      {"MAPE", "mean(|x-r| / (|r| + 0.01 Y))", "", true, &ImageMetrics::mape},
      {"SMAPE", "mean(2|x-r| / (|x| + |r| + 0.01 Y))", "", true, &ImageMetrics::smape},
      {"PSNR", "-10 log10 MSE of clamped sRGB at the stated exposure", "dB", false, &ImageMetrics::psnr},
      {"SSIM", "luminance of clamped sRGB at that exposure, 11x11 Gaussian sigma 1.5, K = .01, .03, valid region", "",
       false, &ImageMetrics::ssim},
      {"LDR_FLIP", "mean FLIP of the clamped image at that exposure, 67.0206 pixels per degree", "", true,
       &ImageMetrics::ldr_flip},
      {"HDR_FLIP", "mean over pixels of the maximum FLIP over the reference's exposures, tone-mapped", "", true,
       &ImageMetrics::hdr_flip}};
  return table;
}

const Metric& find_metric(const std::string& name) {
  std::string known;
  for (const Metric& metric : metric_table()) {
    if (strcasecmp(metric.name.c_str(), name.c_str()) == 0) return metric;
    known += (known.empty() ? "" : ", ") + metric.name;
  }
  throw_error(ErrorClass::usage, "no metric is called '{}'; there are {}", name, known);
}

}  // namespace lucarium
