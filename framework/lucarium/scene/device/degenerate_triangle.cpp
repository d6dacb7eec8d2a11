// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/device/degenerate_triangle.h"

namespace lucarium {

uint64_t degenerate_triangle_count(const Scene& scene) {
  uint64_t count = 0;
  std::vector<glm::vec3> world;
  for (const SceneInstance& instance : scene.instances) {
    const Mesh& shape = instance.shape(scene);
    world.clear();
    for (const glm::vec3& p : shape.positions) world.emplace_back(instance.world_from_object * glm::vec4(p, 1.f));
    for (const glm::uvec3& t : shape.triangles) count += is_degenerate(world[t.x], world[t.y], world[t.z]);
  }
  return count;
}

}  // namespace lucarium
