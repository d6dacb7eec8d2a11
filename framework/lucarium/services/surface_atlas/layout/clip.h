// SPDX-License-Identifier: Apache-2.0
// Triangles cut along the cells of a chart: internal to the surface atlas.
#pragma once
#include <glm/glm.hpp>
#include <vector>

namespace lucarium {

/// The part of a triangle that lies in one cell.
struct ClippedCell {
  int x, y;
  float fraction;  ///< of the triangle's area; 0 for cells that only the dilated cell touches
  float b1, b2;    ///< barycentrics of the piece's centroid
};

/// How far around a cell a look-up may land in it by rounding [cells]: float uv are off by an ulp of the triangle's
/// extent for each of four operations.
double cell_dilation(const glm::dvec2 uv[3]);

/// Appends every cell that touches the triangle when grown by cell_dilation() on all sides, with the exact part of the
/// triangle in the cell itself; fractions sum to 1. Triangles without area in uv are cut along their longest edge.
void clip_to_cells(const glm::dvec2 uv[3], std::vector<ClippedCell>& out);

/// A point of the part of a triangle that lies in a cell, as barycentrics of corners 1 and 2: uniform when `u` is, in
/// [0, 1)². False where that part has no area.
bool sample_in_cell(const glm::dvec2 uv[3], int x, int y, const glm::dvec2& u, float& b1, float& b2);

/// For a cell that only its dilated form touches: a point of the triangle's interior beside the place where it does.
glm::dvec2 point_beside_cell(const glm::dvec2 uv[3], int x, int y);

/// Whether a segment touches the cell grown by `dilation`.
bool segment_touches_cell(const glm::dvec2& a, const glm::dvec2& b, int x, int y, double dilation);

}  // namespace lucarium
