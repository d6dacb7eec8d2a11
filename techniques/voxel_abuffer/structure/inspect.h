// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "voxel_abuffer/structure/voxel_abuffer.h"

namespace lucarium::abuffer {

/// For Technique::inspect(): the voxel of a point of a world triangle, and how its surfaces are searched.
std::vector<std::pair<std::string, std::string>> describe_voxel(const VoxelAbuffer& abuffer, uint32_t triangle,
                                                                const glm::vec3& position);

}  // namespace lucarium::abuffer
