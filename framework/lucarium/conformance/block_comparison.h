// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "lucarium/statistics/image_comparison.h"

namespace lucarium::check {

/// Two sets of independent images of the same thing: the image test (compare/image_test.h) on 8×8 pixel blocks and on
/// the whole image, where right techniques fail with the chance check::level each, and the size of the difference.
struct BlockTest {
  ImageTestLevel blocks, image;
  double rms = 0;    ///< difference of the blocks' means, relative to the second set's, without what noise explains
  double noise = 0;  ///< standard error of that difference, relative root mean square over blocks

  /// Unbiased techniques pass by the tests; those that admit to a bias by the noise-corrected difference.
  bool passes(double bias) const;
  std::string describe(double bias) const;
};

/// Images hold 3 floats per pixel; each set at least two of them.
BlockTest compare_blocks(std::vector<std::vector<float>> a, std::vector<std::vector<float>> b, uint32_t width,
                         uint32_t height);

/// A square picture of check::picture_side pixels a side, 3 floats each, by its seed.
using ImageOfSeed = std::function<std::vector<float>(uint64_t seed)>;
/// Compares pictures of the seeds 1, 2, …: of all check::seeds, or of fewer that are within `bias` beyond doubt.
BlockTest compare_seeds(const ImageOfSeed& a, const ImageOfSeed& b, double bias);

}  // namespace lucarium::check
