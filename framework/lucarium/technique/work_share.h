// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace lucarium {

/// How many units of a cheap part belong into an iteration so that they are `share` (below 1) of its work: 1 to
/// `max_units`. `other`: work of all other parts; `unit`: of one unit; both in the same unit of work. Work is counted,
/// not timed, so that the same seed gives the same bits on every machine.
inline uint32_t units_for_share(double share, double other, double unit, uint32_t max_units) {
  const double units = share / (1 - share) * other / unit;
  return static_cast<uint32_t>(std::clamp(std::round(units), 1.0, static_cast<double>(max_units)));
}

}  // namespace lucarium
