// SPDX-License-Identifier: Apache-2.0
#include "voxel_abuffer/structure_size.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "voxel_abuffer/structure/abuffer_lists.h"
#include "voxel_abuffer/structure/grid_layout.h"
#include "voxel_abuffer/structure/triangle_classes.h"

namespace lucarium::abuffer {
namespace {

/// Pixels that a triangle covers in all three views together, and touches in that of its dominant axis; corners in
/// pixels.
std::array<double, 2> covered_and_touched(const std::array<glm::dvec3, 3>& p) {
  const glm::dvec3 area = 0.5 * glm::abs(glm::cross(p[1] - p[0], p[2] - p[0]));
  const glm::dvec3 size = glm::max(p[0], glm::max(p[1], p[2])) - glm::min(p[0], glm::min(p[1], p[2]));
  const int k = area.x >= area.y && area.x >= area.z ? 0 : area.y >= area.z ? 1 : 2;
  return {area.x + area.y + area.z, area[k] + size[(k + 1) % 3] + size[(k + 2) % 3] + 1};
}

}  // namespace

size_t estimate_structure_bytes(const Scene& scene, const VoxelAbufferOptions& options) {
  const GridSize size = choose_grid_size(options.abuffer_size, options.grid_size);
  const size_t triangles = scene.triangle_count();
  const AbufferGrid grid = make_grid(size, scene.bounds(), static_cast<uint32_t>(triangles));
  const TriangleClasses classes = classify(scene, options.intersect);
  const double per_metre = static_cast<double>(grid.corner.w);
  double parity = 0, exact = 0;
  size_t world_triangle = 0;
  for (const SceneInstance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    for (const auto& triangle : mesh.triangles) {
      std::array<glm::dvec3, 3> corners;
      for (int i = 0; i < 3; ++i)
        corners[i] = per_metre * glm::dvec3(instance.world_from_object * glm::vec4(mesh.positions[triangle[i]], 1.f));
      const auto [covered, touched] = covered_and_touched(corners);
      const bool by_parity = classes.parity[classes.component_of[world_triangle++]];
      if (by_parity && std::isfinite(covered)) parity += covered;
      if (!by_parity && std::isfinite(touched)) exact += touched;
    }
  }
  const auto lists = [&](double fragments) {
    return fragments > 0 ? AbufferLists::estimate_bytes(grid, static_cast<size_t>(1.02 * fragments) + 4096) +
                               LayeredRaster::estimate_bytes(
                                   triangles, {.max_width = size.pixels, .max_height = size.pixels}, true)
                         : size_t{0};
  };
  const size_t per_triangle = sizeof(uint32_t) * (ABUFFER_TRIANGLE_WORDS + 3) + sizeof(AbufferPlane) + 1;
  const size_t bricks = size_t{grid.bricks.x} * grid.bricks.y * grid.bricks.z;
  return triangles * per_triangle + bricks * (64 * sizeof(uint32_t) + sizeof(uint64_t)) + lists(parity) + lists(exact);
}

}  // namespace lucarium::abuffer
