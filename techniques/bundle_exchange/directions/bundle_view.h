// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "bundle_exchange/directions/direction_sequence.h"
#include "lucarium/shared/layered_raster.h"

namespace lucarium::bundle {

/// The film of a bundle: an orthographic view along the direction that holds the projected bounds of the scene.
struct BundleView {
  LayeredView view{};
  double pixel_area = 0;  ///< A_p [m²]
};

/// `pixel`: wanted edge of a film pixel [m], made larger where the film would exceed the raster's limit. The film is
/// turned about the direction and its grid shifted as the direction says.
BundleView make_bundle_view(const Bounds& bounds, const Direction& direction, double pixel, uint32_t seed);

/// Pixels per axis that hold the bounds from every direction.
uint32_t film_side(const Bounds& bounds, double pixel);

}  // namespace lucarium::bundle
