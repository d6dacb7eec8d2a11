// SPDX-License-Identifier: Apache-2.0
// What the technique declares of itself, for parameters, a scene and an image.
#pragma once
#include <string>
#include <vector>

#include "lucarium/technique/technique.h"
#include "micro_rendering/base/micro_parameters.h"

namespace lucarium::micro {

TechniqueInfo technique_info();

/// Scatterings that are computed.
int bounces(const MicroParameters& parameters, const RenderSettings& settings);

/// Whether some surface is rough and lets light through.
bool transmits(const Scene& scene);

PathSet path_set(const MicroParameters& parameters, const RenderSettings& settings);

/// Light of the scene that is left out, and parameters that have no effect, one line each.
std::vector<std::string> limitations(const MicroParameters& parameters, const Scene& scene,
                                     const RenderSettings& settings);

/// Most device bytes that the technique takes.
size_t estimate_bytes(const MicroParameters& parameters, const Scene& scene, const RenderSettings& settings);

}  // namespace lucarium::micro
