// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace lucarium::check {

/// Two sets of independent images of the same thing, compared by the means of 8×8 pixel blocks and channels: Welch's t
/// test per block, Šidák-corrected over all blocks (compare Mitsuba's test_renders.py), so that right techniques fail
/// with the chance check::level in all.
struct BlockTest {
  size_t tests = 0;
  double largest_t = 0;      ///< |t| of the worst block
  double p = 1;              ///< of the whole family
  double rms = 0;            ///< difference of the means, relative to the second set's, without what noise explains
  double noise = 0;          ///< standard error of the difference, relative root mean square over blocks

  /// Unbiased techniques pass by the t tests; those that admit to a bias by the noise-corrected difference.
  bool passes(double bias) const;
  std::string describe(double bias) const;
};

/// Images hold 3 floats per pixel; each set at least two of them.
BlockTest compare_blocks(const std::vector<std::vector<float>>& a, const std::vector<std::vector<float>>& b, uint32_t width,
                         uint32_t height);

}  // namespace lucarium::check
