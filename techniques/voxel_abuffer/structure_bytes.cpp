// SPDX-License-Identifier: Apache-2.0
#include "voxel_abuffer/structure_bytes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "voxel_abuffer/structure/abuffer_lists.h"
#include "voxel_abuffer/structure/grid_layout.h"
#include "voxel_abuffer/structure/triangle_classes.h"

namespace lucarium::abuffer {
namespace {

/// What a triangle takes up in a grid whose cells have edges of 1, in the mean over the grid's positions.
struct Extent {
  double covered = 0;  ///< columns whose centres it covers, over all three axes
  double touched = 0;  ///< columns of its dominant axis that it touches
  double cells = 0;    ///< cubes that it touches
};

Extent extent_of(const std::array<glm::dvec3, 3>& p) {
  const glm::dvec3 area = 0.5 * glm::abs(glm::cross(p[1] - p[0], p[2] - p[0]));
  const glm::dvec3 size = glm::max(p[0], glm::max(p[1], p[2])) - glm::min(p[0], glm::min(p[1], p[2]));
  const int k = area.x >= area.y && area.x >= area.z ? 0 : area.y >= area.z ? 1 : 2;
  const double covered = area.x + area.y + area.z;
  return {covered, area[k] + size[(k + 1) % 3] + size[(k + 2) % 3] + 1, covered + size.x + size.y + size.z + 1};
}

/// Calls f(world triangle, extent) for all triangles that can be hit, in cells of `per_metre`.
template <class F>
void for_each_extent(const Scene& scene, const SceneSubset& subset, double per_metre, F&& f) {
  size_t world_triangle = 0;
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const SceneInstance& instance = scene.instances[i];
    const Mesh& mesh = instance.shape(scene);
    if (!subset.has(i)) {
      world_triangle += mesh.triangles.size();
      continue;
    }
    for (const auto& triangle : mesh.triangles) {
      std::array<glm::dvec3, 3> corners;
      for (int k = 0; k < 3; ++k)
        corners[k] = per_metre * glm::dvec3(instance.world_from_object * glm::vec4(mesh.positions[triangle[k]], 1.f));
      const Extent extent = extent_of(corners);
      if (std::isfinite(extent.cells)) f(world_triangle, extent);
      ++world_triangle;
    }
  }
}

}  // namespace

size_t estimate_abuffer_bytes(const Scene& scene, const VoxelAbufferOptions& options, const SceneSubset& subset) {
  const bool all_exact = options.intersect == Intersect::exact;
  const GridSize size = choose_grid_size(options.abuffer_size, options.grid_size, all_exact);
  const size_t triangles = scene.triangle_count();
  const AbufferGrid grid = make_grid(size, subset.bounds(scene), static_cast<uint32_t>(triangles), subset.min_pixel);
  const TriangleClasses classes = classify(scene, options.intersect, subset);
  const double per_metre = static_cast<double>(grid.corner.w);
  double parity = 0, exact = 0;
  for_each_extent(scene, subset, per_metre, [&](size_t triangle, const Extent& extent) {
    if (classes.parity[classes.component_of[triangle]])
      parity += extent.covered;
    else
      exact += extent.touched;
  });
  const auto lists = [&](double fragments, bool stored) {
    return fragments > 0
               ? AbufferLists::estimate_bytes(grid, static_cast<size_t>(1.02 * fragments) + 4096, stored) +
                     LayeredRaster::estimate_bytes(triangles, {.max_width = size.pixels, .max_height = size.pixels},
                                                   LayeredStoreOptions{.variant = options.list})
               : size_t{0};
  };
  const size_t per_triangle = sizeof(uint32_t) * (ABUFFER_TRIANGLE_WORDS + 3) + sizeof(AbufferPlane) + 1;
  const size_t bricks = brick_count(grid);
  // Word, first cell block, and for parity the normals along three axes.
  const size_t per_voxel = 2 * sizeof(uint32_t) + (parity > 0 ? 3 * sizeof(int2) : 0);
  // A surface has a fragment per pixel; its voxels, each with a cell block, are twice as many as if it lay across one
  // axis.
  const double pixels = static_cast<double>(grid.voxels.w) * grid.voxels.w;
  const auto cells = static_cast<size_t>(2 * exact / pixels * sizeof(uint64_t) * ABUFFER_CELL_WORDS);
  const bool reaches = parity > 0 && options.intersect != Intersect::plane && keeps_reaches(grid);
  return triangles * per_triangle + bricks * (64 * per_voxel + (reaches ? 66 : 2) * sizeof(uint64_t)) + cells +
         lists(parity, options.attributes == Attributes::stored) + lists(exact, false);
}

size_t estimate_compared_bytes(const Scene& scene, const GridSize& size, bool blocks) {
  const auto triangles = static_cast<uint32_t>(scene.triangle_count());
  const AbufferGrid grid = make_grid(size, scene.bounds(), triangles);
  double pairs = 0;
  const double voxels_per_metre = static_cast<double>(grid.corner.w) / grid.voxels.w;
  for_each_extent(scene, {}, voxels_per_metre, [&](size_t, const Extent& extent) { pairs += extent.cells; });
  const size_t bricks = brick_count(grid);
  // Sorting pairs takes their keys, numbers, triangles and as much again; a block of eight triangles is 320 bytes.
  return triangles * size_t{16} + bricks * size_t{40} + static_cast<size_t>(pairs) * (blocks ? 40 + 320 : 60);
}

}  // namespace lucarium::abuffer
