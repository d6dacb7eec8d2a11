// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

namespace lucarium {

/// Exposure [stops] at which this image (linear RGB, 3 values a pixel) can be displayed. The measure is the 90th
/// percentile of the brightest channel over all lit pixels (finite, above 0), so that neither a black background nor
/// fireflies matter. Where it lies from 0.2 to 1, which displays show well, the result is 0; otherwise it is moved
/// to the nearer end of that range. Rounded to tenths of a stop, so that it can be stated (--exposure) for the same
/// picture.
float automatic_exposure(const std::vector<float>& rgb);

}  // namespace lucarium
