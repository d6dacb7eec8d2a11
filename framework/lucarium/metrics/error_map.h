// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

namespace lucarium {

/// Relative luminance error (Y_test − Y_ref)/(Y_ref + 0.01 Ȳ_ref) of every pixel; 1 where the test is not finite.
/// `test` and `reference`: RGB floats of equal size. FLIP's maps: FlipReference::error_map (flip.h).
std::vector<float> signed_relative_error(const std::vector<float>& test, const std::vector<float>& reference);

/// Values clamped to ±1 as a picture: blue too dark, white right, red too bright (a diverging scale for colour-blind
/// readers too). Linear RGB, for write_png/encode_png at exposure 0.
std::vector<float> color_signed_error(const std::vector<float>& error);

/// Values clamped to [0,1] as a picture, from black over purple and orange to pale yellow, ever lighter; linear RGB.
std::vector<float> color_error(const std::vector<float>& error);

}  // namespace lucarium
