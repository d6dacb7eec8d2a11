// SPDX-License-Identifier: Apache-2.0
#include "voxel_abuffer/structure/triangle_classes.h"

#include <map>

#include "lucarium/scene/mesh_components.h"
#include "voxel_abuffer/shared/abuffer_layout.h"

namespace lucarium::abuffer {

namespace {

/// Components of no importance: triangles of a subset all alike, and others.
TriangleClasses classify_all(const Scene& scene, bool exact, const SceneSubset& subset) {
  TriangleClasses classes;
  classes.parity = {static_cast<uint8_t>(exact ? 0 : ABUFFER_PARITY), ABUFFER_ABSENT};
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const size_t triangles = scene.instances[i].shape(scene).triangles.size();
    classes.component_of.insert(classes.component_of.end(), triangles, subset.has(i) ? 0 : 1);
    if (subset.has(i)) (exact ? classes.exact_triangles : classes.parity_triangles) += static_cast<uint32_t>(triangles);
  }
  return classes;
}

}  // namespace

TriangleClasses classify(const Scene& scene, Intersect intersect, const SceneSubset& subset) {
  // These need to know nothing of components.
  if (intersect == Intersect::exact || intersect == Intersect::plane)
    return classify_all(scene, intersect == Intersect::exact, subset);
  TriangleClasses classes;
  std::map<const Mesh*, MeshComponents> meshes;  // instances share them
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const Mesh& mesh = scene.instances[i].shape(scene);
    const auto [found, is_new] = meshes.try_emplace(&mesh);
    if (is_new) found->second = mesh_components(mesh.positions, mesh.triangles);
    const MeshComponents& parts = found->second;
    const auto first = static_cast<uint32_t>(classes.parity.size());
    for (const uint32_t component : parts.component_of) classes.component_of.push_back(first + component);
    for (const MeshComponent& part : parts.components) {
      if (!subset.has(i)) {
        classes.parity.push_back(ABUFFER_ABSENT);
        continue;
      }
      const bool parity = intersect == Intersect::parity || (intersect == Intersect::automatic && part.closed);
      const uint32_t sides = ABUFFER_PARITY | (part.closed ? (part.volume < 0 ? ABUFFER_ROOM : 0u) : ABUFFER_OPEN);
      classes.parity.push_back(static_cast<uint8_t>(parity ? sides : 0));
      (parity ? classes.parity_triangles : classes.exact_triangles) += part.triangles;
      classes.open_components += !part.closed;
    }
  }
  return classes;
}

}  // namespace lucarium::abuffer
