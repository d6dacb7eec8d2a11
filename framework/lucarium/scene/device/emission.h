// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <glm/glm.hpp>
#include <map>

#include "lucarium/scene/scene.h"

namespace lucarium {

/// Emits, reflects and transmits on both sides: `doubleSided`, or transmissive.
inline bool is_two_sided(const SceneMaterial& material) { return material.double_sided || material.transmission > 0; }

/// Mean radiance of emissive triangles. Keeps what it learns about whole textures while the scene lives.
class EmissionEstimator {
 public:
  explicit EmissionEstimator(const Scene& scene) : scene_(scene) {}

  /// Mean radiance [cd/m²] that a triangle of `mesh` emits per side: factors times the texture's mean over the
  /// triangle's footprint (times vertex colours for unlit materials). It weighs light samples and sums up fluxes, so
  /// it may be approximate for large footprints, but it is 0 only where no point of the triangle emits anything.
  glm::vec3 mean_radiance(const Mesh& mesh, const glm::uvec3& triangle, const SceneMaterial& material);

 private:
  glm::vec3 mean_over_rectangle(int texture, const glm::vec2 uv[3]);

  const Scene& scene_;
  std::map<int, glm::vec3> whole_texture_;  ///< mean over all texels
};

/// Flux of a spot light per unit of its intensity [sr], by KHR_lights_punctual's squared ramp.
double spot_solid_angle(const SceneLight& light);

/// Scale and offset of that ramp: attenuation = clamp(cos·scale + offset, 0, 1)².
glm::vec2 spot_ramp(const SceneLight& light);

}  // namespace lucarium
