// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/surface_atlas/layout/look_up.h"

#include <algorithm>

namespace lucarium {

uint32_t atlas_cell(const AtlasTriangle& t, float b1, float b2) {
  const auto along = [&](float a, float b, float c) {
    const float x = a + b1 * (b - a) + b2 * (c - a);
    return std::min(std::max(x, std::min(a, std::min(b, c))), std::max(a, std::max(b, c)));
  };
  return t.base + static_cast<uint32_t>(along(t.v0, t.v1, t.v2)) * LUCARIUM_ATLAS_PITCH(t) +
         static_cast<uint32_t>(along(t.u0, t.u1, t.u2));
}

}  // namespace lucarium
