// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/scene/scene.h"
#include "voxel_abuffer/structure/voxel_abuffer.h"

namespace lucarium::abuffer {

/// Device bytes that a VoxelAbuffer will take, from the expected numbers of fragments of the scene's triangles: the
/// pixels that a triangle covers in each view, or touches in that of its dominant axis.
size_t estimate_structure_bytes(const Scene& scene, const VoxelAbufferOptions& options);

}  // namespace lucarium::abuffer
