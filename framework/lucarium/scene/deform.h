// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <glm/glm.hpp>
#include <vector>

#include "lucarium/scene/scene.h"

namespace lucarium {

/// Transform of normals: the inverse transpose, up to a positive factor, also where the matrix has rank 2 (a scale of
/// 0 along one axis). Computed from the cofactors.
glm::mat3 normal_matrix(const glm::mat3& m);

/// The mesh with its morph targets added, weighted (missing weights count as 0); object space. Flat normals are
/// recomputed from the moved triangles.
Mesh morph(const Mesh& mesh, const std::vector<float>& weights);

/// Linear blend skinning (glTF 2.0, section 3.7.3.3) in place: `world_from_bind[j]` is joint j's world transform times
/// its inverse bind matrix. Vertices without any weight follow `fallback`. Returns whether most vertices were
/// mirrored, so that the triangles' winding is reversed.
bool skin(Mesh& mesh, const std::vector<glm::mat4>& world_from_bind, const glm::mat4& fallback);

/// Sets every vertex normal to its triangle's; triangles without area keep what they have.
void recompute_flat_normals(Mesh& mesh, bool reversed_winding);

}  // namespace lucarium
