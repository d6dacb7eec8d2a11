// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/services/bundles/direction_sequence.h"
#include "lucarium/shared/layered_raster.h"

namespace lucarium {

/// The image of a bundle: an orthographic view along its direction that holds the projected bounds of the scene, for
/// LayeredRaster. Each of its pixels is a ray of the bundle.
struct BundleView {
  LayeredView view{};
  double pixel_area = 0;  ///< A_p [m²]
};

/// `pixel`: wanted edge of a pixel [m]; made larger where the image would exceed LAYERED_MAX_EDGE. The image is turned
/// about the direction and its pixel grid shifted as the direction says; `seed` decides BLEND. Computed in double
/// precision (orthographic_view() is not): rows are rounded once, so that pixels of all directions have the same area.
BundleView make_bundle_view(const Bounds& bounds, const BundleDirection& direction, double pixel, uint32_t seed);

/// Pixels per axis that hold the bounds from every direction: size of the raster.
uint32_t bundle_side(const Bounds& bounds, double pixel);

}  // namespace lucarium
