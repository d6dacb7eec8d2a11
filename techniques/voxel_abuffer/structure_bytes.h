// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/scene/scene.h"
#include "voxel_abuffer/structure/grid_layout.h"
#include "voxel_abuffer/structure/voxel_abuffer.h"

namespace lucarium::abuffer {

/// Device bytes that a VoxelAbuffer will take, from the expected numbers of fragments: the pixels that triangles cover
/// in each view, or touch in that of their dominant axis.
size_t estimate_abuffer_bytes(const Scene& scene, const VoxelAbufferOptions& options, const SceneSubset& subset = {});

/// The same of a structure to compare with, over `size` voxels along the longest side: from the expected number of
/// voxels that triangles touch. `blocks`: each voxel has a list of triangles.
size_t estimate_compared_bytes(const Scene& scene, const GridSize& size, bool blocks);

}  // namespace lucarium::abuffer
