// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "lucarium/services/surface_atlas/surface_atlas.h"

namespace lucarium {

/// The texel side at a point (barycentrics b1, b2) of a world triangle; LUCARIUM_NONE behind a single-sided surface.
/// Reads from the device.
uint32_t side_at(const SurfaceAtlas& atlas, uint32_t triangle, float b1, float b2, bool front);

/// What Technique::inspect() says of a texel side: (name, value) of its number, its size, and what reaches it.
/// `shown`: per texel side, irradiance over π times accessibility, and accessibility; or of all open halves, then of
/// all covered ones (SideAccessibility). `name`: of that light.
std::vector<std::pair<std::string, std::string>> describe_side(const SurfaceAtlas& atlas, uint32_t side,
                                                               const TypedBuffer<float4>& shown,
                                                               const std::string& name);

}  // namespace lucarium
