// SPDX-License-Identifier: Apache-2.0
// How much of an error is bias, which more samples of the same kind never remove, and how much is variance.
#pragma once
#include <cstdint>
#include <vector>

#include "lucarium/statistics/statistics.h"

namespace lucarium {

/// Which error is split: MSE, or relMSE with its weights 1/(r² + .01 Ȳ²).
enum class ErrorScale { absolute, relative };

/// Images of one variant with different seeds against one reference, reduced to what the split needs.
struct SeedImages {
  std::vector<double> products;  ///< S·S: ⟨w (x_s − r)(x_t − r)⟩ over pixels and channels
  std::vector<double> means;     ///< S: mean of x_s over pixels and channels [cd/m²]
  double reference_mean = 0;     ///< the same of r
  size_t seeds = 0;
  uint64_t nonfinite = 0;  ///< pixels left out because some x_s is not finite there
};

/// `images`, `reference`: RGB floats of one size. Throws Error{input} when sizes differ or no pixel is finite.
SeedImages reduce_seed_images(const std::vector<std::vector<float>>& images, const std::vector<float>& reference,
                              ErrorScale scale);

/// E(error of one image) = bias² + variance, each estimated without bias from S ≥ 2 independent images; NaN for one.
struct BiasAndVariance {
  size_t seeds = 0;
  double error = 0;          ///< mean error of one image, the reference's own subtracted
  double variance = 0;       ///< of one image; falls to 1/k of it with k times the samples
  double error_of_mean = 0;  ///< of the mean over the seeds, as measured: bias² + variance/S + reference's own
  double bias2 = 0;          ///< error_of_mean − variance/S − reference's own; may be below 0 by chance
  double bias2_error =
      0;  ///< standard error of bias2, by the jackknife over seeds (cautious: docs/metrics.md); NaN below 3
  /// √(error_of_mean / (variance/S + reference's own)): error of the mean in units of its standard error. About 1
  /// without bias; infinite for an image that is wrong and does not vary; 0 for one that is right and does not.
  double standard_errors = 0;
  ConfidenceInterval relative_mean;  ///< (mean of x_s − mean of r)/mean of r, with its interval over the seeds
  double mean_t = 0;  ///< the same in units of its standard error: Student's t with S − 1 degrees of freedom
};

/// `reference_error`: own error of the reference on the same scale (ReferenceError, reference_image.h), 0 if exact. The
/// interval and t of the mean take the reference's mean as exact.
BiasAndVariance split_error(const SeedImages& images, double reference_error);

}  // namespace lucarium
