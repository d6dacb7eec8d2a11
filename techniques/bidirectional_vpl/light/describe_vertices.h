// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "bidirectional_vpl/light/light_vertices.h"

namespace lucarium::bidirectional {

/// For Technique::inspect(): the light vertices of the last iteration that a camera path's vertex at a point may be
/// connected to, what they would bring there, and the strongest ones. Reads them from the device.
InspectedValues describe_vertices(const LightVertices& vertices, const Plan& plan, const SeenPoint& point);

/// For the same: the samples that each strategy's weight counts.
InspectedValues describe_weights(const Plan& plan);

}  // namespace lucarium::bidirectional
