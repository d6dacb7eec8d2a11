// SPDX-License-Identifier: Apache-2.0
// Numbers with a name, beside those of <numbers>.
#pragma once
#include <limits>
#include <numbers>

namespace lucarium {

inline constexpr double pi = std::numbers::pi;
inline constexpr double infinity = std::numeric_limits<double>::infinity();
inline constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

}  // namespace lucarium
