// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "bundle_exchange/base/parameters.h"
#include "lucarium/technique/technique.h"

namespace lucarium::bundle {

TechniqueInfo technique_info();

/// The light paths that these parameters compute.
PathSet path_set(const Parameters& parameters, const RenderSettings& settings);

/// Throws Error{usage} for what does not go together.
void check_parameters(const Parameters& parameters);

/// Technique::endless(). A preview is shown until the exchange ends, and some exchanges divide what they have.
std::vector<std::pair<std::string, std::string>> endless(const Parameters& parameters);

/// Technique::state_refusal().
std::string state_refusal(const Parameters& parameters);

}  // namespace lucarium::bundle
