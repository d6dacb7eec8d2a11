// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "lucarium/scene/scene.h"

namespace lucarium::abuffer {

/// A part of a scene, instance by instance.
struct SceneSubset {
  std::vector<bool> instances;  ///< those that belong to it; empty: all
  float min_pixel = 0;          ///< its pixels are no smaller [m]

  bool whole() const { return instances.empty(); }
  bool has(size_t instance) const { return whole() || instances[instance]; }
  /// World space, at the evaluated time.
  Bounds bounds(const Scene& scene) const;
};

/// The instances that hang on a node which some animation moves, or that are skinned or morphed.
SceneSubset moving_instances(const Scene& scene);
/// All others.
SceneSubset resting_instances(const Scene& scene);

}  // namespace lucarium::abuffer
