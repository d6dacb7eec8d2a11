// SPDX-License-Identifier: Apache-2.0
// Whether TEXCOORD_1 can lay out an atlas: internal to the surface atlas.
#pragma once
#include <vector>

#include "lucarium/services/surface_atlas/layout/mesh.h"

namespace lucarium {

/// Per instance: metres per unit of TEXCOORD_1 where it lays out the atlas, else 0; empty when none does. Throws
/// Error{input} that names the mesh and the triangles for coordinates that are folded within an island, overlap, or
/// whose density is off by more than 2 from the instance's mean in some direction (over more than a thousandth of its
/// area).
std::vector<double> check_texcoord1(const AtlasMesh& mesh);

/// Whether TEXCOORD_1 is continuous across an edge.
bool texcoord1_goes_on(const AtlasMesh& mesh, uint32_t triangle, int edge, uint32_t other);

}  // namespace lucarium
