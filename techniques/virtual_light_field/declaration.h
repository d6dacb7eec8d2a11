// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/technique/technique.h"
#include "virtual_light_field/base/parameters.h"

namespace lucarium::vlf {

TechniqueInfo technique_info();

/// The light paths that these parameters compute.
PathSet path_set(const Parameters& parameters, const Scene& scene, const RenderSettings& settings);

/// Throws Error{usage} for what does not go together.
void check_parameters(const Parameters& parameters, const Scene& scene, const RenderSettings& settings);

std::vector<std::string> limitations(const Parameters& parameters, const Scene& scene, const RenderSettings& settings);

}  // namespace lucarium::vlf
