// SPDX-License-Identifier: Apache-2.0
#include "voxel_abuffer/structure/inspect.h"

#include <fmt/format.h>

#include "voxel_abuffer/structure/state.h"

namespace lucarium::abuffer {
namespace {

/// As abuffer_voxel() (structure/grid.clh).
size_t voxel_index(const AbufferGrid& grid, const glm::uvec3& voxel) {
  const glm::uvec3 brick = voxel >> 2u, within = voxel & 3u;
  return size_t{(brick.z * grid.bricks.y + brick.y) * grid.bricks.x + brick.x} * 64 + within.z * 16 + within.y * 4 +
         within.x;
}

std::string search_of(uint32_t triangle_class) {
  if (triangle_class & ABUFFER_OPEN) return "parity, without an inside";
  if (triangle_class & ABUFFER_PARITY) return triangle_class & ABUFFER_ROOM ? "parity, a room" : "parity, a solid";
  return "exact";
}

std::string kinds_in(uint32_t word) {
  std::string text;
  for (uint32_t axis = 0; axis < 3; ++axis)
    if (word & ABUFFER_EXACT(axis)) text += fmt::format("{}exact along {}", text.empty() ? "" : ", ", "xyz"[axis]);
  if (word & ABUFFER_PARITY) {
    const uint32_t axis = word >> ABUFFER_AXIS_SHIFT & 3u;
    text += fmt::format("{}parity along {}", text.empty() ? "" : ", ", axis == 3 ? "any" : std::string(1, "xyz"[axis]));
  }
  return text.empty() ? "nothing" : text;
}

}  // namespace

std::vector<std::pair<std::string, std::string>> describe_voxel(const VoxelAbuffer& abuffer, uint32_t triangle,
                                                                const glm::vec3& position) {
  const VoxelAbuffer::State& state = abuffer.state();
  if (!state.voxels) return {};
  const AbufferGrid& grid = state.grid;
  const glm::uvec3 count(grid.voxels.x, grid.voxels.y, grid.voxels.z);
  const glm::vec3 center(grid.center.x, grid.center.y, grid.center.z),
      corner(grid.corner.x, grid.corner.y, grid.corner.z);
  const glm::vec3 pixel = ((position - center) - corner) * grid.corner.w;
  const glm::uvec3 voxel(
      glm::clamp(pixel / static_cast<float>(grid.voxels.w), glm::vec3(0), glm::vec3(count) - glm::vec3(1)));
  return {
      {"A-buffer pixel", fmt::format("{:.2f}, {:.2f}, {:.2f}, of {:.4g} m", pixel.x, pixel.y, pixel.z, grid.center.w)},
      {"voxel", fmt::format("{}, {}, {} of {} × {} × {}", voxel.x, voxel.y, voxel.z, count.x, count.y, count.z)},
      {"in the voxel", kinds_in(state.voxels.download(voxel_index(grid, voxel), 1).front())},
      {"search of the triangle", search_of(state.triangle_classes.download(triangle, 1).front())}};
}

}  // namespace lucarium::abuffer
