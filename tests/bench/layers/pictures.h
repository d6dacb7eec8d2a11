// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "lucarium/services/layered_raster/layered_raster.h"

namespace lucarium {

/// Writes PREFIX_layers.png (fragments per pixel, white is the most) and PREFIX_depth.png (nearest, near is white) of a
/// view.
void write_pictures(KernelScheduler& scheduler, const LayeredRaster& raster, const LayeredView& view,
                    const std::string& prefix);

}  // namespace lucarium
