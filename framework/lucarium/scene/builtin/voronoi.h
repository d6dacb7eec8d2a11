// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace lucarium {

/// The half-space n·x ≤ offset; n has unit length.
struct HalfSpace {
  glm::dvec3 n;
  double offset;
};

/// A convex polyhedron whose faces share its corners: closed, whatever is rounded.
struct ConvexCell {
  struct Face {
    std::vector<uint32_t> corners;  ///< counter-clockwise seen from outside
    bool outer;                     ///< lies on the whole's surface
  };
  std::vector<glm::dvec3> corners;
  std::vector<Face> faces;
};

/// Cuts off what lies outside a half-space; the new face gets that mark. Leaves nothing where all is outside.
void clip(ConvexCell& cell, const HalfSpace& half_space, bool outer);

/// Makes one corner of those that edges shorter than `length` join; faces that vanish are left out.
void collapse_short_edges(ConvexCell& cell, double length);

/// The Voronoi cells of points in a convex body around the origin that is the intersection of half-spaces at a
/// distance of at least `inner` and lies within the cube |x|, |y|, |z| ≤ `half_edge`. Together they fill it. Expects
/// points inside it that differ.
std::vector<ConvexCell> voronoi_cells(std::span<const glm::dvec3> points, std::span<const HalfSpace> body, double inner,
                                      double half_edge);

}  // namespace lucarium
