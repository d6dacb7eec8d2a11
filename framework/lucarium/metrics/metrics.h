// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "lucarium/metrics/flip.h"

namespace lucarium {

/// Error of a test image x against a reference r. Averages run over pixels and channels; Ȳ is the reference's mean
/// luminance. Pixels of x that are not finite are counted and left out of every average. The formulas and their
/// sources: docs/metrics.md.
struct ImageMetrics {
  double mse = 0;             ///< ⟨(x−r)²⟩ [(cd/m²)²]
  double rmse = 0;            ///< √MSE [cd/m²]
  double relmse = 0;          ///< ⟨(x−r)²/(r²+.01Ȳ²)⟩
  double relmse_trimmed = 0;  ///< the same without the largest 0.1 % of pixels
  double mape = 0;            ///< ⟨|x−r|/(r+.01Ȳ)⟩
  double smape = 0;           ///< ⟨2|x−r|/(|x|+|r|+.01Ȳ)⟩
  double psnr = 0;      ///< −10 log10 MSE of the clamped sRGB images at the given exposure [dB]; infinite when equal
  double ssim = 0;      ///< of the luminance of those; NaN when the 11×11 window does not fit
  double ldr_flip = 0;  ///< mean FLIP at the given exposure; NaN when not asked for
  double hdr_flip = 0;  ///< mean of the greatest FLIP over the reference's exposures; NaN when not asked for
  double mean_test = 0, mean_reference = 0;  ///< mean over pixels and channels [cd/m²]
  uint64_t nonfinite = 0;                    ///< pixels of x with NaN or infinity
};

/// One metric: everything that a table, a JSON file or a report says about it.
struct Metric {
  std::string name;     ///< "relMSE_trimmed"
  std::string formula;  ///< in ASCII
  std::string unit;     ///< "" for a ratio
  bool lower_is_better = true;
  double ImageMetrics::*value = nullptr;
};

/// All metrics in printing order.
const std::vector<Metric>& metric_table();
/// Throws Error{usage} that lists the names when none is called `name`. Upper and lower case are the same.
const Metric& find_metric(const std::string& name);

struct MetricOptions {
  float exposure_stops = 0;  ///< of PSNR, SSIM and LDR-FLIP
  bool flip = true;          ///< without it, ldr_flip and hdr_flip are NaN and the rest is several times faster
};

/// A reference with what the metrics need of it, for many test images.
class MetricReference {
 public:
  /// `reference`: RGB floats, width · height · 3. Throws Error{input} on another size or values that are not finite.
  MetricReference(uint32_t width, uint32_t height, std::vector<float> reference, const MetricOptions& options = {});
  ~MetricReference();
  MetricReference(MetricReference&&) noexcept;
  MetricReference& operator=(MetricReference&&) noexcept;

  /// `test`: RGB floats of the same size. Throws Error{input} when sizes differ or no pixel is finite.
  ImageMetrics measure(const std::vector<float>& test) const;
  /// ImageMetrics::relmse, in a fraction of the time that all of them take. Throws like measure().
  double relmse(const std::vector<float>& test) const;
  /// FLIP of every pixel, in [0,1]. Throws Error{internal} when FLIP was not asked for, otherwise like measure().
  std::vector<float> ldr_flip_map(const std::vector<float>& test) const;
  std::vector<float> hdr_flip_map(const std::vector<float>& test) const;
  const HdrFlipExposures& hdr_exposures() const;

 private:
  struct Prepared;
  std::unique_ptr<Prepared> prepared_;
};

/// All metrics of one pair of images: MetricReference for a single test image.
ImageMetrics compute_metrics(uint32_t width, uint32_t height, const std::vector<float>& test,
                             const std::vector<float>& reference, float exposure_stops = 0);

/// Rec.709 luminance averaged over an RGB image.
double mean_luminance(const std::vector<float>& rgb);

}  // namespace lucarium
