// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <vector>

#include "lucarium/scene/scene.h"

namespace lucarium {

/// Rebuilds every vertex attribute so that new vertex i is a copy of old vertex `source[i]`; triangles are not touched.
void gather_vertices(Mesh& mesh, const std::vector<uint32_t>& source);

/// Gives every triangle its own three vertices with the triangle's normal, and sets flat_normals.
void make_flat_normals(Mesh& mesh);

/// Makes normals unit-length; those without a direction become the area-weighted mean of their triangles' normals.
/// Returns how many had none.
size_t repair_normals(Mesh& mesh);

/// Makes per-vertex tangents along +u of texture coordinates `uv` (one per vertex; with the texture transform of the
/// normal map applied), averaged with the angles of triangles at the vertex as weights, orthogonal to the normal; w is
/// the sign for which w·(n × t) points along -v, up in the image. Vertices that mirrored and unmirrored triangles
/// share are split. Approximates MikkTSpace, which glTF names as its default; it differs where MikkTSpace would split
/// a vertex for another reason.
void make_tangents(Mesh& mesh, const std::vector<glm::vec2>& uv);

/// Makes tangents unit-length and w ±1; those without a direction become an arbitrary one in the surface.
void repair_tangents(Mesh& mesh);

}  // namespace lucarium
