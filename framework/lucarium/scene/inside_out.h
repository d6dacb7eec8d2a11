// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "lucarium/scene/scene.h"

namespace lucarium {

/// Names of the meshes that are closed and wound inside out: their single-sided triangles turn their black backs to a
/// camera that stands outside. A mesh counts that encloses a negative volume, whose edges are each shared in opposite
/// directions, whose material is opaque and single-sided, and in which the scene's first camera does not stand: rooms
/// are meant to be seen from within. At the evaluated time; each name once.
std::vector<std::string> meshes_inside_out(const Scene& scene);

}  // namespace lucarium
