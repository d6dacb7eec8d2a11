// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <vector>

#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/scene/scene.h"

namespace lucarium::vlf {

/// Triangles in world space.
struct PatchMesh {
  std::vector<Triangle> triangles;
  std::vector<glm::vec3> positions, normals;  ///< per vertex; per triangle, 0 without area
  std::vector<double> areas;                  ///< [m²]

  /// All triangles of a scene, with their numbers.
  explicit PatchMesh(const SceneBuffers& buffers);
  /// Those of the instances that are `taken` (1), of a scene that is on no device yet.
  PatchMesh(const Scene& scene, const std::vector<uint8_t>& taken);

 private:
  void measure();
};

/// Patch of each triangle that is taken: connected sets of one instance around the largest triangle that is left.
/// `cone`: PatchOptions::cone. `count`: of patches.
std::vector<uint32_t> grow_patches(const PatchMesh& mesh, const std::vector<uint8_t>& taken, double cone,
                                   uint32_t* count);

/// Connected set of each triangle, where neighbours' normals are at most `angle` [degrees] apart: numbers of triangles.
std::vector<uint32_t> connected_surfaces(const PatchMesh& mesh, double angle);

}  // namespace lucarium::vlf
