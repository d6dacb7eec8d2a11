// SPDX-License-Identifier: Apache-2.0
#include "lucarium/film/exposure.h"

#include <algorithm>
#include <cmath>

namespace lucarium {
namespace {

constexpr double percentile = 0.9;
constexpr float darkest = 0.2f, brightest = 1;  // linear; 0.2 is 0.48 in sRGB
constexpr float max_stops = 100;                // 2^±100 is a finite float

}  // namespace

float automatic_exposure(const std::vector<float>& rgb) {
  std::vector<float> lit;
  lit.reserve(rgb.size() / 3);
  for (size_t i = 0; i + 2 < rgb.size(); i += 3) {
    const float largest = std::max({rgb[i], rgb[i + 1], rgb[i + 2]});
    const bool finite = std::isfinite(rgb[i]) && std::isfinite(rgb[i + 1]) && std::isfinite(rgb[i + 2]);
    if (finite && largest > 0) lit.push_back(largest);
  }
  if (lit.empty()) return 0;
  const auto at = lit.begin() + static_cast<std::ptrdiff_t>(percentile * static_cast<double>(lit.size() - 1));
  std::nth_element(lit.begin(), at, lit.end());
  const float wanted = std::clamp(*at, darkest, brightest);
  if (wanted == *at) return 0;
  const float stops = std::clamp(std::log2(wanted) - std::log2(*at), -max_stops, max_stops);
  return std::round(10 * stops) / 10 + 0.f;  // never -0
}

}  // namespace lucarium
