// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <vector>

#include "voxel_abuffer/base/scene_subset.h"

namespace lucarium::abuffer {

/// How rays find hits.
enum class Intersect {
  automatic,  ///< closed components by parity, the others exactly
  parity,     ///< all by parity: wrong where components are open
  exact,      ///< by the triangles of fragments: hits of Bvh
  plane,      ///< by the planes of fragments within their pixels
};

/// Edge-connected components of all instances, each with the way in which it is searched.
struct TriangleClasses {
  std::vector<uint32_t> component_of;  ///< per world triangle
  /// Per component: ABUFFER_PARITY, perhaps with ABUFFER_ROOM; 0: exact; ABUFFER_ABSENT: of another subset.
  std::vector<uint8_t> parity;
  uint32_t parity_triangles = 0, exact_triangles = 0;
  uint32_t open_components = 0;
};

/// Corners are welded by equal positions within an instance. `doubleSided`, MASK and BLEND do not matter.
TriangleClasses classify(const Scene& scene, Intersect intersect, const SceneSubset& subset = {});

}  // namespace lucarium::abuffer
