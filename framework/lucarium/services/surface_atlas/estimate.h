// SPDX-License-Identifier: Apache-2.0
// How large an atlas gets: internal to the surface atlas.
#pragma once
#include "lucarium/scene/scene.h"
#include "lucarium/services/surface_atlas/layout/layout.h"

namespace lucarium {

/// Area of all reflecting sides [m²].
double reflecting_area(const Scene& scene);

/// Texel sides that reflecting sides of `area` [m²] are meant to have.
double wanted_sides(double area, const AtlasLayoutOptions& options);

/// `largest`: the largest number of texel sides that an atlas of a geometry has, otherwise the likely one (normals and
/// texture coordinates do not matter). Surfaces that touch nothing have a texel each at any edge, and long ones of them
/// as many as lie along them.
double count_sides(const AtlasGeometry& geometry, const AtlasLayoutOptions& options, bool largest = true);
double count_sides(const Scene& scene, const AtlasLayoutOptions& options, bool largest = true);

}  // namespace lucarium
