// SPDX-License-Identifier: Apache-2.0
// The exposure that a user states: a number of stops, or that it is chosen from the image (film/exposure.h).
#pragma once
#include <cmath>
#include <limits>
#include <string>
#include <string_view>

namespace lucarium {

/// Stands where stops do: chosen from the image.
inline constexpr float exposure_automatic = std::numeric_limits<float>::quiet_NaN();
inline bool is_automatic(float exposure_stops) { return std::isnan(exposure_stops); }

/// A finite number of stops, or "auto"; throws Error{usage}.
float parse_exposure(std::string_view text);

/// As parse_exposure() reads it.
std::string exposure_text(float exposure_stops);

}  // namespace lucarium
