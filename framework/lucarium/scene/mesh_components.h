// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace lucarium {

/// Triangles of a mesh that hang together by edges.
struct MeshComponent {
  uint32_t triangles = 0;  ///< how many
  /// Whether they enclose volumes: every edge is run through as often in one direction as in the other. No column of
  /// pixels then sees more fronts than backs, or fewer.
  bool closed = true;
  double volume = 0;  ///< as signed_volume() of them alone
};

struct MeshComponents {
  std::vector<MeshComponent> components;  ///< in the order of their first triangles
  std::vector<uint32_t> component_of;     ///< per triangle
};

/// Splits triangles into components. Corners are one where their positions are equal; to touch in a corner alone does
/// not join. A triangle whose edges have no length is a component of its own, and closed.
MeshComponents mesh_components(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles);

/// Volume that closed triangles enclose [cube of the positions' unit]: negative where they are clockwise seen from
/// outside, 0 without triangles. Of open ones it says nothing.
double signed_volume(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles);

}  // namespace lucarium
