// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/path_set.h"

namespace lucarium {

/// Whether light of this kind (LUCARIUM_LIGHT_*) belongs to the path set.
bool includes_light(const PathSet& set, uint32_t kind);

/// The alias table of the mixture from which one light is drawn per vertex, like the scene's own, but with probability
/// 0 for lights outside of the path set. Meaningless when no light is left.
std::vector<AliasEntry> make_light_mixture(const std::vector<Light>& lights, LightChoice choice, const PathSet& set);

/// The same of where its light trees begin, from the scene's own: without the kinds of lights outside of the path set,
/// and without any unless `choice` is LightChoice::tree.
std::vector<uint> make_light_trees(std::vector<uint> header, LightChoice choice, const PathSet& set);

}  // namespace lucarium
