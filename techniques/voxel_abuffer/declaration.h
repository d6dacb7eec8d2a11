// SPDX-License-Identifier: Apache-2.0
// What the technique declares of itself, for parameters, a scene and an image.
#pragma once
#include <string>
#include <vector>

#include "lucarium/technique/technique.h"
#include "voxel_abuffer/modes/eye_trees.h"
#include "voxel_abuffer/parameters.h"

namespace lucarium::abuffer {

TechniqueInfo technique_info();

/// Systematic error, as Capabilities::bias says: 0 where hits are those of a hierarchy. `declared`: of search by parity
/// with 2D-DDA and 1280 pixels. Parity errs in a band along edges, as wide as a pixel or a step.
double admitted_bias(const AbufferParameters& parameters, double declared);

PathSet path_set(const AbufferParameters& parameters, const RenderSettings& settings);

/// What is left out, and parameters that have no effect, one line each.
std::vector<std::string> limitations(const AbufferParameters& parameters, const Scene& scene,
                                     const RenderSettings& settings);

/// Most device bytes of the mode and of the structure.
size_t estimate_bytes(const AbufferParameters& parameters, const Scene& scene, const RenderSettings& settings);

/// ao_radius in metres, INFINITY without one.
float occlusion_radius(const AbufferParameters& parameters, const Scene& scene);

EyeTrees::Options tree_options(const AbufferParameters& parameters);

/// Throws Error{usage} for values that do not go together.
void check_parameters(const AbufferParameters& parameters, const RenderSettings& settings);

/// Whether what pixels see first is rasterized.
bool rasterizes_primary(const AbufferParameters& parameters, const RenderSettings& settings);

}  // namespace lucarium::abuffer
