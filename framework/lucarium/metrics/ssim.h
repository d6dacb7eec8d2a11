// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <vector>

namespace lucarium {

/// Structural similarity with a reference: Wang et al., "Image Quality Assessment: From Error Visibility to Structural
/// Similarity", IEEE TIP 13(4), 2004, eq. 13. Windows of 11×11 pixels, Gaussian weights of σ = 1.5, K = .01 and .03,
/// range 1, population moments; windows that leave the image are left out. The reference's moments are computed once.
class SsimReference {
 public:
  /// `values`: one in [0,1] per pixel, width · height.
  SsimReference(uint32_t width, uint32_t height, std::vector<double> values);
  /// Mean over the windows whose middle pixel is not marked in `excluded` (empty: none is). NaN without any window.
  double compare(const std::vector<double>& test, const std::vector<bool>& excluded = {}) const;

 private:
  uint32_t width_, height_;
  std::vector<double> values_, mean_, mean_square_;
};

}  // namespace lucarium
