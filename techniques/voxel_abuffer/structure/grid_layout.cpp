// SPDX-License-Identifier: Apache-2.0
#include "voxel_abuffer/structure/grid_layout.h"

#include <algorithm>
#include <cmath>

#include "lucarium/base/error.h"
#include "lucarium/services/layered_raster/layered_raster.h"

namespace lucarium::abuffer {

namespace {

constexpr float margin = 2;               // pixels on each side
constexpr float rounding = 2.4e-7f;       // four units of a float's last place
constexpr uint32_t max_exact = 256;       // voxels for exact search: their words grow with the cube
constexpr size_t max_reaches = 1u << 20;  // voxels that have reaches: eight bytes each
constexpr uint32_t min_edge = 8;          // pixels along an edge of a voxel that is searched at points

uint32_t component(const uint4& v, int k) { return k == 0 ? v.x : k == 1 ? v.y : v.z; }

}  // namespace

GridSize choose_grid_size(uint32_t pixels, uint32_t voxels, bool exact) {
  if (voxels == 0 && exact) {
    voxels = std::min((pixels + ABUFFER_CELLS - 1) / ABUFFER_CELLS, max_exact);
  } else if (voxels == 0) {
    const auto root = static_cast<uint32_t>(std::ceil(std::sqrt(3.0 * pixels)));
    voxels = std::min((root + 15) / 16 * 16, pixels);
  }
  if (voxels > pixels)
    throw_error(ErrorClass::usage, "voxel_abuffer: grid_size={} exceeds abuffer_size={}; voxels have whole pixels",
                voxels, pixels);
  if (pixels > ABUFFER_MAX_VOXEL_EDGE * voxels)
    throw_error(ErrorClass::usage, "voxel_abuffer: abuffer_size={} with grid_size={}; voxels have at most {} pixels",
                pixels, voxels, ABUFFER_MAX_VOXEL_EDGE);
  const uint32_t edge = std::min((pixels + voxels - 1) / voxels, LAYERED_MAX_EDGE / voxels);
  return {edge * voxels, voxels};
}

bool searches_points(const GridSize& size) { return size.pixels >= min_edge * size.voxels; }

AbufferGrid make_grid(const GridSize& size, const Bounds& bounds, uint32_t triangles, float min_pixel) {
  const glm::vec3 low = bounds.empty() ? glm::vec3(0) : bounds.min, high = bounds.empty() ? glm::vec3(0) : bounds.max;
  if (!std::isfinite(glm::dot(high - low, glm::vec3(1))))
    throw Error(
        ErrorClass::input,
        "voxel_abuffer: the scene has positions that are infinite, and so would be its voxels; mend its meshes");
  const glm::vec3 extent = high - low, reach = glm::max(glm::abs(low), glm::abs(high));
  const float largest = std::max({reach.x, reach.y, reach.z});
  const float longest = std::max({extent.x, extent.y, extent.z});
  const auto n = static_cast<float>(size.pixels), edge = static_cast<float>(size.pixels / size.voxels);
  const float pixel = std::max({longest / (n - 2 * margin), largest * rounding, 1e-12f, min_pixel});
  AbufferGrid grid{};
  std::array<uint32_t, 3> voxels{};
  glm::vec3 corner;
  for (int k = 0; k < 3; ++k) {
    const float wanted = std::ceil((extent[k] / pixel + 2 * margin) / edge);
    voxels[k] = std::clamp(static_cast<uint32_t>(wanted), 1u, size.voxels);
    corner[k] = -0.5f * static_cast<float>(voxels[k]) * edge * pixel;
  }
  grid.center = float4(low + 0.5f * extent, pixel);
  grid.corner = float4(corner, 1 / pixel);
  grid.voxels = {voxels[0], voxels[1], voxels[2], size.pixels / size.voxels};
  grid.bricks = {(voxels[0] + 3) / 4, (voxels[1] + 3) / 4, (voxels[2] + 3) / 4, 0};
  for (int k = 0; k < 3; ++k) grid.bricks.w = std::max(grid.bricks.w, axis_pixels(grid, k) + 1);
  grid.slack = rounding * largest / pixel;
  grid.triangles = triangles;
  grid.per_edge = 1 / static_cast<float>(grid.voxels.w);
  return grid;
}

LayeredView axis_view(const AbufferGrid& grid, int k, uint32_t classes) {
  const int x = (k + 1) % 3, y = (k + 2) % 3;
  glm::vec3 direction(0), right(0);
  direction[k] = right[x] = 1;
  const glm::vec3 corner = grid.corner.xyz();
  LayeredView view =
      orthographic_view(grid.center.xyz(), direction, right, grid.center.w, component(grid.voxels, x) * grid.voxels.w,
                        component(grid.voxels, y) * grid.voxels.w, -corner[k], {corner[x], corner[y]});
  view.classes = classes;
  return view;
}

bool keeps_reaches(const AbufferGrid& grid) { return brick_count(grid) <= max_reaches / 64; }

size_t brick_count(const AbufferGrid& grid) { return size_t{grid.bricks.x} * grid.bricks.y * grid.bricks.z; }

uint32_t axis_pixels(const AbufferGrid& grid, int k) {
  return component(grid.voxels, (k + 1) % 3) * component(grid.voxels, (k + 2) % 3) * grid.voxels.w * grid.voxels.w;
}

}  // namespace lucarium::abuffer
