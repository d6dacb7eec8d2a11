// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/surface_atlas/layout/layout.h"

namespace lucarium {

/// Per instance: whether both of its sides have texels in an atlas.
std::vector<uint8_t> two_sided_instances(const Scene& scene);

/// The scene's world-space triangles as the device derived them. `use_texcoord1`: lay out by TEXCOORD_1 where it is.
AtlasGeometry read_atlas_geometry(const Scene& scene, const SceneBuffers& buffers, bool use_texcoord1);

}  // namespace lucarium
