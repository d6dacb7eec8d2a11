// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/results/bias.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lucarium/base/error.h"
#include "lucarium/base/numbers.h"
#include "lucarium/metrics/metrics.h"

namespace lucarium {
namespace {

/// Sums of the products of different seeds and of each with itself, over all seeds but `left_out`.
struct ProductSums {
  double own = 0, cross = 0;
};

ProductSums sum_products(const SeedImages& images, size_t left_out) {
  ProductSums sums;
  for (size_t s = 0; s < images.seeds; ++s) {
    for (size_t t = 0; t < images.seeds; ++t) {
      if (s == left_out || t == left_out) continue;
      (s == t ? sums.own : sums.cross) += images.products[s * images.seeds + t];
    }
  }
  return sums;
}

/// Jackknife standard error of the mean of the products of different seeds.
double jackknife_error(const SeedImages& images) {
  const size_t n = images.seeds;
  if (n < 3) return not_a_number;
  std::vector<double> without;
  double mean = 0;
  for (size_t s = 0; s < n; ++s) {
    without.push_back(sum_products(images, s).cross / static_cast<double>((n - 1) * (n - 2)));
    mean += without.back() / static_cast<double>(n);
  }
  double squares = 0;
  for (const double value : without) squares += (value - mean) * (value - mean);
  return std::sqrt(squares * static_cast<double>(n - 1) / static_cast<double>(n));
}

double ratio_root(double numerator, double denominator) {
  return numerator > 0 ? std::sqrt(numerator / denominator) : 0;
}

}  // namespace

SeedImages reduce_seed_images(const std::vector<std::vector<float>>& images, const std::vector<float>& reference,
                              ErrorScale scale) {
  SeedImages reduced;
  const size_t seeds = reduced.seeds = images.size();
  for (const std::vector<float>& image : images) {
    if (image.size() != reference.size()) {
      throw_error(ErrorClass::input, "images of different size cannot be compared: {} and {} values", image.size(),
                  reference.size());
    }
  }
  reduced.products.assign(seeds * seeds, 0);
  reduced.means.assign(seeds, 0);
  const double luminance = mean_luminance(reference), floor2 = 0.01 * luminance * luminance + 1e-24;
  std::vector<double> difference(seeds);
  size_t pixels = 0;
  for (size_t p = 0; p < reference.size() / 3; ++p) {
    bool finite = true;
    for (const std::vector<float>& image : images) {
      for (size_t c = 0; c < 3; ++c) finite = finite && std::isfinite(image[3 * p + c]);
    }
    if (!finite) {
      ++reduced.nonfinite;
      continue;
    }
    ++pixels;
    for (size_t i = 3 * p; i < 3 * p + 3; ++i) {
      const double r = reference[i], weight = scale == ErrorScale::relative ? 1 / (r * r + floor2) : 1;
      reduced.reference_mean += r;
      for (size_t s = 0; s < seeds; ++s) {
        difference[s] = images[s][i] - r;
        reduced.means[s] += images[s][i];
        for (size_t t = 0; t <= s; ++t) reduced.products[s * seeds + t] += weight * difference[s] * difference[t];
      }
    }
  }
  if (pixels == 0) throw_error(ErrorClass::input, "no pixel is finite in the images of all seeds");
  const double values = 3.0 * static_cast<double>(pixels);
  reduced.reference_mean /= values;
  for (size_t s = 0; s < seeds; ++s) {
    reduced.means[s] /= values;
    for (size_t t = 0; t <= s; ++t) {
      reduced.products[t * seeds + s] = reduced.products[s * seeds + t] /= values;
    }
  }
  return reduced;
}

BiasAndVariance split_error(const SeedImages& images, double reference_error) {
  const auto seeds = static_cast<double>(images.seeds);
  const ProductSums sums = sum_products(images, images.seeds);
  BiasAndVariance split;
  split.seeds = images.seeds;
  split.error = sums.own / seeds - reference_error;
  split.error_of_mean = (sums.own + sums.cross) / (seeds * seeds);

  std::vector<double> relative;
  for (const double mean : images.means) relative.push_back((mean - images.reference_mean) / images.reference_mean);
  split.relative_mean = seed_mean(relative);
  if (images.seeds < 2) {
    split.variance = split.bias2 = split.bias2_error = split.standard_errors = split.mean_t = not_a_number;
    return split;
  }
  // ⟨d_s d_t⟩ of independent seeds has the expectation ⟨bias²⟩ + the reference's own error: that of bias2 is exact.
  const double between = sums.cross / (seeds * (seeds - 1));
  split.variance = std::max(0.0, sums.own / seeds - between);  // below 0 by rounding at most
  split.bias2 = between - reference_error;
  split.bias2_error = jackknife_error(images);
  split.standard_errors = ratio_root(split.error_of_mean, split.variance / seeds + reference_error);

  double squares = 0;
  for (const double value : relative)
    squares += (value - split.relative_mean.mean) * (value - split.relative_mean.mean);
  const double error = std::sqrt(squares / (seeds * (seeds - 1)));
  split.mean_t = split.relative_mean.mean == 0 ? 0 : split.relative_mean.mean / error;
  return split;
}

}  // namespace lucarium
