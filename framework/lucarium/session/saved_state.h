// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/technique/state_file.h"
#include "lucarium/technique/technique.h"

namespace lucarium {

/// What a state of this technique, on this scene, belongs to.
StateHeader state_header(const TechniqueInfo& info, Technique& technique, const Scene& scene,
                         const RenderSettings& settings);

/// Throws Error{usage} for a technique that has no state with its present parameters: why, in its own words.
void require_state(const TechniqueInfo& info, const Technique& technique);

/// Throws where the state belongs to something else: Error{usage} for what the command line says (technique,
/// parameters other than those of the view, bounces, seed), Error{input} for the rest (scene, version, light paths).
void require_same(const StateFile& state, const TechniqueInfo& info, Technique& technique, const Scene& scene,
                  const RenderSettings& settings);

}  // namespace lucarium
