// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

namespace lucarium {

/// Stops at which a picture of this image (linear RGB, 3 values a pixel) can be looked at. The measure is the 90th
/// percentile of the brightest channel over all lit pixels (finite, above 0), so that neither a black background nor
/// fireflies matter. From 0.2 to 1 it is what a display shows well, and the result is 0; else it is brought to the
/// nearer end of that range. Rounded to tenths of a stop, so that it can be stated (--exposure) for the same picture.
float automatic_exposure(const std::vector<float>& rgb);

}  // namespace lucarium
