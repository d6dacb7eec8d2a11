// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

namespace lucarium {

/// Albedos of the GGX reflection lobe, as kernels/lucarium/specular_albedo.clh lays them out (scene_albedo_table);
/// computed offline to about 1e-6 by tools/specular_albedo.cpp.
std::vector<float> specular_albedo_table();

}  // namespace lucarium
