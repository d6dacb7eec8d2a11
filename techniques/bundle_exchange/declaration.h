// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "bundle_exchange/base/parameters.h"
#include "lucarium/technique/technique.h"

namespace lucarium::bundle {

TechniqueInfo technique_info();

/// The light paths that these parameters compute.
PathSet path_set(const Parameters& parameters, const RenderSettings& settings);

/// Technique::state_refusal().
std::string state_refusal(const Parameters& parameters);

}  // namespace lucarium::bundle
