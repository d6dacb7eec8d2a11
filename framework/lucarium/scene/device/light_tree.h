// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <glm/vec3.hpp>
#include <vector>

#include "lucarium/shared/scene_types.h"

namespace lucarium {

/// Where a light is and how it sends its light: a triangle's corners and front normal, a spot's place and axis, …
struct LightBounds {
  glm::vec3 lower{0}, upper{0};  ///< the box around it [m]
  glm::vec3 axis{0, 0, 1};       ///< unit
  float spread = 0;              ///< half angle of the cone of axes [rad]; π: any direction
  float reach = 0;               ///< how far off its axis it sends anything [rad]
  /// Most that it sends in one direction [cd], of a textured triangle on average; of a sun what it sends to a plane
  /// that faces it, of the environment to a plane in the mean over all planes [lx].
  float power = 0;
};

/// The trees by which light samples choose lights for a point (kernels/lucarium/light_tree.clh), in the layout of
/// kernels/lucarium/shared/light_tree.h.
struct LightTree {
  std::vector<uint> header;  ///< scene_light_trees
  std::vector<uint> nodes;   ///< scene_light_nodes
  std::vector<uint> places;  ///< scene_light_places: per light
};

/// Splits sets of lights where the sum over both halves of power · area of the sphere · solid angle of the cone is
/// least (Conty Estevez and Kulla 2018, section 4.1; they have the area of the box). in_use: whether light samples
/// choose by it.
LightTree make_light_tree(const std::vector<Light>& lights, const std::vector<LightBounds>& bounds, bool in_use);

/// Of more lights word indices would reach LUCARIUM_LIGHT_LEAF.
inline constexpr size_t max_tree_lights = size_t{1} << 24;

/// Words of the nodes of the largest tree over so many lights.
size_t light_tree_capacity(size_t lights);

}  // namespace lucarium
