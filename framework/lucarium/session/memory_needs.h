// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <string>

#include "lucarium/technique/technique.h"

namespace lucarium {

/// Device bytes that rendering will take: scene, BVH where the technique uses one, and technique, as they state it.
size_t needed_bytes(const TechniqueInfo& info, const Technique& technique, const Scene& scene,
                    const RenderSettings& settings);

/// What to do where memory does not suffice: settings that save some, those of the framework, and the technique's
/// parameters, tried at half their value (at 1 where the smallest value stands for an automatic choice), largest
/// savings first. Parameters have their values again afterwards.
std::string memory_hint(Technique& technique, const Scene& scene, const RenderSettings& settings);

}  // namespace lucarium
