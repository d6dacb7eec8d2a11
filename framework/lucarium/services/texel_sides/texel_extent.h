// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/surface_atlas/surface_atlas.h"

namespace lucarium {

/// Largest distance between two points of one texel [m], where it is more than `limit`; else something below it. From
/// the pieces of triangles that texels are made of: exact, except for texels of more than a thousand corners, for which
/// it is the diagonal of their box.
double largest_texel_extent(const SurfaceAtlas& atlas, const SceneBuffers& buffers, double limit);

}  // namespace lucarium
