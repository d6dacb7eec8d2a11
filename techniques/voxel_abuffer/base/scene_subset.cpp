// SPDX-License-Identifier: Apache-2.0
#include "voxel_abuffer/base/scene_subset.h"

#include "lucarium/scene/animation.h"

namespace lucarium::abuffer {

Bounds SceneSubset::bounds(const Scene& scene) const {
  if (whole()) return scene.bounds();
  Bounds all;
  for (size_t i = 0; i < instances.size(); ++i)
    if (instances[i]) all.add(scene.instance_bounds(static_cast<int>(i)));
  return all;
}

SceneSubset moving_instances(const Scene& scene) {
  const std::vector<bool> moving = animated_nodes(scene);
  SceneSubset subset;
  for (const SceneInstance& instance : scene.instances)
    subset.instances.push_back(instance.pose != nullptr ||
                               (instance.node != none && moving[static_cast<size_t>(instance.node)]));
  return subset;
}

SceneSubset resting_instances(const Scene& scene) {
  SceneSubset subset = moving_instances(scene);
  subset.instances.flip();
  return subset;
}

}  // namespace lucarium::abuffer
