// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace lucarium {

/// Error of a test image x against a reference r. Averages run over pixels and channels; Ȳ is the reference's mean
/// luminance. Non-finite pixels of x are left out of the averages and counted.
struct ImageMetrics {
  double mse = 0;             ///< ⟨(x−r)²⟩ [(cd/m²)²]
  double rmse = 0;            ///< √MSE [cd/m²]
  double relmse = 0;          ///< ⟨(x−r)²/(r²+.01Ȳ²)⟩
  double relmse_trimmed = 0;  ///< the same without the largest 0.1 % of pixels
  double mape = 0;            ///< ⟨|x−r|/(r+.01Ȳ)⟩
  double smape = 0;           ///< ⟨2|x−r|/(|x|+|r|+.01Ȳ)⟩
  double psnr = 0;            ///< −10 log10 MSE of the clamped sRGB images at the given exposure [dB]; infinite when equal
  double ssim = 0;            ///< of the luminance of those, 11×11 Gaussian σ=1.5, K=.01/.03, valid region
  double mean_test = 0, mean_reference = 0;  ///< mean over pixels and channels [cd/m²]
  uint64_t nonfinite = 0;     ///< pixels of x with NaN or infinity
};

/// `test`, `reference`: RGB floats, width · height · 3. Throws Error{input} when sizes differ or the reference is not
/// finite. SSIM of images smaller than its 11×11 window is 0.
ImageMetrics compute_metrics(uint32_t width, uint32_t height, const std::vector<float>& test,
                             const std::vector<float>& reference, float exposure_stops = 0);

/// (name, formula) of every metric, in printing order.
const std::vector<std::pair<std::string, std::string>>& metric_formulas();
/// Value by name of metric_formulas().
double metric_value(const ImageMetrics& metrics, const std::string& name);

/// Rec.709 luminance averaged over an RGB image.
double mean_luminance(const std::vector<float>& rgb);

}  // namespace lucarium
