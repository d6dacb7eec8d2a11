// SPDX-License-Identifier: Apache-2.0
// The transfer curve of sRGB, IEC 61966-2-1.
#pragma once
#include <cmath>

namespace lucarium {

/// Display value in [0,1] of a linear one in [0,1].
inline double srgb_from_linear(double x) { return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055; }

/// Its inverse.
inline double linear_from_srgb(double s) { return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4); }

}  // namespace lucarium
