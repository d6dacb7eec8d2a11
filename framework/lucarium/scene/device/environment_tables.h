// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <glm/glm.hpp>
#include <vector>

#include "lucarium/scene/scene.h"
#include "lucarium/shared/scene_types.h"

namespace lucarium {

/// scene_environment and scene_environment_cdf of kernels/lucarium/shared/scene_buffers.h. Empty for a constant
/// environment.
struct EnvironmentTables {
  std::vector<float4> texels;
  std::vector<float> cdf;
};

/// Texels are weighted by the mean luminance of the *bilinear* lookup over the texel's cell (closed form from its 3×3
/// neighbourhood, wrapping in u, clamping in v) times the cell's solid angle. Where that is positive it is raised to
/// at least 1 % of its row's mean, and rows likewise, so that single precision keeps every cell that emits reachable.
EnvironmentTables make_environment_tables(const Environment& environment);

/// ∫ L dω over the sphere, factor included [lm/m²]: π R² times it is the flux through a sphere of radius R.
glm::vec3 environment_integral(const Environment& environment);

}  // namespace lucarium
