// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

namespace lucarium {

/// Signed relative luminance error (Y_test − Y_ref)/(Y_ref + 0.01 Ȳ_ref), clamped to ±1, as a picture: blue too dark,
/// white right, red too bright (a diverging scale that colour-blind readers can tell). `test` and `reference`: RGB
/// floats of equal size; the result is linear RGB for write_png/encode_png at exposure 0.
std::vector<float> signed_error_map(const std::vector<float>& test, const std::vector<float>& reference);

}  // namespace lucarium
