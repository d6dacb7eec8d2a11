// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "lucarium/scene/scene.h"

namespace lucarium {

/// Directions in proportion to the mean luminance of an environment's texels: what directions of bundles may be guided
/// by. Computed on the host in double precision; light sampling on the device has its own tables (environment.clh).
class EnvironmentGuide {
 public:
  /// `environment` has an image; a black one guides uniformly.
  explicit EnvironmentGuide(const Environment& environment);
  /// World direction at a point of [0, 1)².
  glm::vec3 sample(double u, double v) const;
  double density(const glm::vec3& direction) const;  ///< [1/sr]

 private:
  uint32_t width_, height_;
  glm::mat3 environment_from_world_;
  std::vector<double> rows_;     ///< height + 1 cumulative values
  std::vector<double> columns_;  ///< height × (width + 1)
};

/// Null for no environment or a constant one, by which uniform directions are guided already.
std::shared_ptr<const EnvironmentGuide> make_environment_guide(const Environment* environment);

}  // namespace lucarium
