// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/scene.h"

namespace lucarium {

uint64_t Scene::triangle_count() const {
  uint64_t count = 0;
  for (const SceneInstance& instance : instances) count += meshes[instance.mesh].triangles.size();
  return count;
}

}  // namespace lucarium
