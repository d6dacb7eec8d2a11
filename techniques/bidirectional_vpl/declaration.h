// SPDX-License-Identifier: Apache-2.0
// What the technique declares of itself, for parameters, a scene and an image.
#pragma once
#include <string>
#include <vector>

#include "bidirectional_vpl/base/parameters.h"
#include "lucarium/technique/technique.h"

namespace lucarium::bidirectional {

TechniqueInfo technique_info();

/// Systematic error, as Capabilities::bias says: that of dependent directions, and of pixels of rasterized bundles.
double admitted_bias(const BidirectionalParameters& parameters, double declared);

PathSet path_set(const BidirectionalParameters& parameters, const RenderSettings& settings);

/// Whether a surface of the scene may reflect or refract ideally.
bool may_be_ideal(const Scene& scene);

/// Light of the scene that is left out, and parameters that have no effect, one line each.
std::vector<std::string> limitations(const BidirectionalParameters& parameters, const Scene& scene,
                                     const RenderSettings& settings);

/// Most device bytes that the technique takes.
size_t estimate_bytes(const BidirectionalParameters& parameters, const Scene& scene, const RenderSettings& settings);

/// Throws Error{usage} for values that do not go together.
void check_parameters(const BidirectionalParameters& parameters, const RenderSettings& settings);

}  // namespace lucarium::bidirectional
