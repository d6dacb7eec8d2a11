// SPDX-License-Identifier: Apache-2.0
#include "voxel_abuffer/structure/triangle_classes.h"

#include <map>

#include "lucarium/scene/mesh_components.h"
#include "voxel_abuffer/shared/abuffer_layout.h"

namespace lucarium::abuffer {

TriangleClasses classify(const Scene& scene, Intersect intersect) {
  TriangleClasses classes;
  if (intersect == Intersect::exact || intersect == Intersect::plane) {  // need to know nothing of components
    const bool exact = intersect == Intersect::exact;
    const auto triangles = static_cast<uint32_t>(scene.triangle_count());
    (exact ? classes.exact_triangles : classes.parity_triangles) = triangles;
    classes.component_of.assign(triangles, 0);
    classes.parity = {static_cast<uint8_t>(exact ? 0 : ABUFFER_PARITY)};
    return classes;
  }
  std::map<const Mesh*, MeshComponents> meshes;  // instances share them
  for (const SceneInstance& instance : scene.instances) {
    const Mesh& mesh = instance.shape(scene);
    const auto [found, is_new] = meshes.try_emplace(&mesh);
    if (is_new) found->second = mesh_components(mesh.positions, mesh.triangles);
    const MeshComponents& parts = found->second;
    const auto first = static_cast<uint32_t>(classes.parity.size());
    for (const uint32_t component : parts.component_of) classes.component_of.push_back(first + component);
    for (const MeshComponent& part : parts.components) {
      const bool parity = intersect == Intersect::parity || (intersect == Intersect::automatic && part.closed);
      const uint32_t sides = part.volume < 0 ? ABUFFER_PARITY | ABUFFER_ROOM : ABUFFER_PARITY;
      classes.parity.push_back(static_cast<uint8_t>(parity ? sides : 0));
      (parity ? classes.parity_triangles : classes.exact_triangles) += part.triangles;
      classes.open_components += !part.closed;
    }
  }
  return classes;
}

}  // namespace lucarium::abuffer
