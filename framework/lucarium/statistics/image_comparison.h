// SPDX-License-Identifier: Apache-2.0
// Are two independent renders of one scene the same up to noise? Student's t per pixel, per block and for the whole
// image (docs/validation.md).
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "lucarium/film/film.h"

namespace lucarium {

/// An image of independent pixels with its own error: mean and variance of the mean, 3 values per pixel.
struct ImageEstimate {
  uint32_t width = 0, height = 0;
  std::vector<double> mean, variance;
  double dof = 0;                              ///< degrees of freedom of every variance
  std::vector<std::vector<float>> replicates;  ///< R independent images of which it was made; may be empty

  /// From R ≥ 2 independent renders, RGB. Means of blocks take their error from the replicates too, so pixels need not
  /// be independent (reconstruction filters). Throws Error{input} when sizes differ or a value is not finite.
  static ImageEstimate from_replicates(uint32_t width, uint32_t height, std::vector<std::vector<float>> replicates);
  /// From the image, layer "Variance" and metadata "variance_dof" of a render with replicates=R. Throws Error{input}
  /// that names `shown_name` without them.
  static ImageEstimate from_film(const Film& film, const std::string& shown_name);
};

struct ImageTestOptions {
  double level = 0.01;  ///< probability that pixels, or blocks, of two perfect renders fail (Šidák over all of them)
  double image_level = 4.7e-4;  ///< the same of one channel of the image's mean: |z| > 3.5
  uint32_t block = 8;           ///< side of the blocks [pixels]
  double tolerance = 0;  ///< relative difference that is none, for renderers that round or tabulate; of each mean
};

/// Outcome for the pixels, the blocks or the image as a whole.
struct ImageTestLevel {
  std::string name;       ///< "pixels", "blocks", "image"
  uint64_t tests = 0;     ///< values with noise
  uint64_t constant = 0;  ///< values without noise on either side: not tested, only compared
  uint64_t failures = 0;  ///< p below `level`, or constants that differ by more than a ten-thousandth
  double level = 0;       ///< of one test
  double smallest_p = 1, worst_t = 0;
  uint32_t worst_x = 0, worst_y = 0, worst_channel = 0;
  double ks_statistic = 0;  ///< Kolmogorov-Smirnov distance of the p-values from uniform
  double ks_p = 1;          ///< and its probability; reported, not judged: fireflies make p-values too large
};

struct ImageTest {
  std::vector<ImageTestLevel> levels;
  double mean_a = 0, mean_b = 0;  ///< of all values [cd/m²]
  bool passed = false;            ///< no failures on any level
};

/// Welch's t on every value. Variances have a floor of (1e-5 of the value)², the rounding of films. Throws Error{input}
/// when sizes differ.
ImageTest test_images(const ImageEstimate& a, const ImageEstimate& b, const ImageTestOptions& options = {});

/// A line per level and one for the means.
std::string to_text(const ImageTest& test);

/// P(D > d) for the Kolmogorov-Smirnov distance of n values, Stephens' approximation.
double kolmogorov_tail(double distance, size_t values);

}  // namespace lucarium
