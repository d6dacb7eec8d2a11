// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstdint>

namespace lucarium::bundle {

/// Weight of the i-th value (from 1 on) in a mean in which value i counts i²: of a mean over all, ever later ones.
/// i² / Σ i² = 6 i / ((i + 1) (2 i + 1)).
inline float late_weight(uint32_t i) {
  const double n = std::max(i, 1u);
  return static_cast<float>(6 * n / ((n + 1) * (2 * n + 1)));
}

}  // namespace lucarium::bundle
