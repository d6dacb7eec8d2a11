// SPDX-License-Identifier: Apache-2.0
// What the neighbours of a triangle say about the discs on it: where its surface ends or bends away, and what sheet it
// is of.
#pragma once
#include <vector>

#include "micro_rendering/points/scene_sides.h"
#include "micro_rendering/shared/micro_types.h"

namespace lucarium::micro {

/// By world triangle; of those in no source: no edges, no sheet. Triangles are neighbours that share two corners of the
/// same position in the space in which points are placed. An edge counts where the surface ends, or bends away from the
/// triangle's front by more than 20 degrees (two-sided ones: to either side). Its own edges come first, then those of
/// the neighbours that go on smoothly.
std::vector<MicroPatch> find_patches(const std::vector<TreeSource>& sources, const std::vector<Triangle>& triangles);

}  // namespace lucarium::micro
