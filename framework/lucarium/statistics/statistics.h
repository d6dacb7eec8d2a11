// SPDX-License-Identifier: Apache-2.0
// Intervals from a few independent seeds. The formulas with their sources: docs/metrics.md.
#pragma once
#include <cstddef>
#include <vector>

namespace lucarium {

/// A mean over independent seeds with an interval that holds the expected value with the given confidence. Without
/// values, or when one of them is NaN, all is NaN; one value has an interval without bounds.
struct ConfidenceInterval {
  double mean = 0;
  double low = 0, high = 0;
  size_t seeds = 0;
};

/// Arithmetic mean with Student's interval: mean ± t s/√n with n − 1 degrees of freedom.
ConfidenceInterval seed_mean(const std::vector<double>& values, double confidence = 0.95);

/// The same of log(value), given as exp: geometric mean of positive values such as errors and times, whose spread is a
/// factor. When one value is 0 so is the mean, and the interval has no upper bound unless all are. Throws
/// Error{internal} on a negative value.
ConfidenceInterval seed_geometric_mean(const std::vector<double>& values, double confidence = 0.95);

/// Mean of a[i] − b[i], two variants with the same seeds, so that what the seeds have in common cancels. Throws
/// Error{internal} when the sizes differ.
ConfidenceInterval paired_difference(const std::vector<double>& a, const std::vector<double>& b,
                                     double confidence = 0.95);

/// Geometric mean of a[i]/b[i]: below 1 a has the lower error, for certain where even `high` is. Pairs of two zeros are
/// ratios of 1. Throws like seed_geometric_mean and paired_difference.
ConfidenceInterval paired_ratio(const std::vector<double>& a, const std::vector<double>& b, double confidence = 0.95);

/// An error against a reference that has an error of its own.
struct DebiasedError {
  double value = 0;      ///< error − reference error: the expected error against the truth; may be below 0 by chance
  bool resolved = true;  ///< the reference's own error is at most a tenth of the measured one
};

/// For MSE and relMSE, where the independent errors of image and reference add up.
DebiasedError debiased_error(double error, double reference_error);

}  // namespace lucarium
