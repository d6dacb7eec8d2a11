// SPDX-License-Identifier: Apache-2.0
// What the neighbours of a triangle say about the discs on it: where its surface ends or bends away, and what sheet it
// is of.
//
// A disc of radius r = disc_scale r_0, π r_0² = A / n, stands for the surface about a point. It errs in two ways that
// do not vanish with better cuts or more samples:
//
// - Beyond an edge it stands in the air. The disc of a point at distance s < r from an edge reaches r - s beyond it: a
//   strip looks up to 2 r wider, an opening up to 2 r narrower. So up to MICRO_CLIPS lines bound a leaf's disc. Concave
//   edges bound nothing: the overhang lies inside the adjoining wall.
// - On a bent two-sided sheet it shows the wrong side. On a sheet of radius of curvature R the disc of a point at
//   distance x passes x² / 2R above a gather on the convex side, and shows it the sheet's other side. So leaves within
//   4 radii are skipped that lie on the other side of the same sheet: triangles joined by common edges and wound alike
//   there. From one side of such a sheet the other cannot be seen but around its border. (Single-sided surfaces show
//   their backs there, which are skipped.)
//
// A cut-off disc keeps at least the area A / n that its leaf stands for: all lines are moved outwards alike until it
// does. Otherwise facets smaller than a disc, most of which have no point, would be holes. So details much finer than
// the discs are still too large. Splats are not cut off.
#pragma once
#include <vector>

#include "micro_rendering/points/scene_sides.h"
#include "micro_rendering/shared/micro_types.h"

namespace lucarium::micro {

/// By world triangle; of those in no source: no edges, no sheet. Triangles are neighbours that share two corners of the
/// same position in the space in which points are placed. An edge counts where the surface ends, or bends away from the
/// triangle's front by more than 20 degrees (two-sided ones: to either side). Its own edges come first, then those of
/// the neighbours that go on smoothly.
std::vector<TriangleEdges> find_triangle_edges(const std::vector<TreeSource>& sources,
                                               const std::vector<Triangle>& triangles);

}  // namespace lucarium::micro
