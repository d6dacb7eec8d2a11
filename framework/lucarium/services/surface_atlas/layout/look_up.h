// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

#include "lucarium/shared/surface_atlas.h"

namespace lucarium {

/// The cell of a point of a triangle, by the operations of kernels/lucarium/surface_atlas.clh.
uint32_t atlas_cell(const AtlasTriangle& triangle, float b1, float b2);

}  // namespace lucarium
