// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>

#include "lucarium/scene/scene.h"
#include "lucarium/shared/layered_raster.h"
#include "voxel_abuffer/shared/abuffer_layout.h"

namespace lucarium::abuffer {

/// Sizes of the structure: n² pixels per A-buffer, N voxels along the longest side.
struct GridSize {
  uint32_t pixels = 1280;  ///< n, a multiple of N
  uint32_t voxels = 64;    ///< N
};

/// Where `voxels` is 0, N = √(3n) rounded up to a multiple of 16 (Hu et al. 2014, section 5), or with `exact`, where
/// all search is, n / 8, 256 at most: cells are pixels up to n = 2048. n rounded up to a multiple of N, or down where
/// it would exceed what can be rasterized, so that voxel faces are pixel edges. Throws Error{usage} naming
/// `abuffer_size` and `grid_size` where N > n, or voxels have more pixels than ABUFFER_MAX_VOXEL_EDGE.
GridSize choose_grid_size(uint32_t pixels, uint32_t voxels, bool exact = false);

/// Whether voxels are large enough to be searched at points along the ray: from 8 pixels along an edge. In smaller ones
/// all columns are visited, whatever is asked for: what lies between two points, which are a pixel apart there, would
/// be lost, and columns cost no more.
bool searches_points(const GridSize& size);

/// The grid around a scene's bounds: cubic voxels, N along the longest side and in proportion along the others, at
/// least two pixels of margin on every side. Flat, empty and far scenes get one with edges well above rounding errors.
/// `min_pixel`: no pixel is smaller [m]; the grid has fewer then.
AbufferGrid make_grid(const GridSize& size, const Bounds& bounds, uint32_t triangles, float min_pixel = 0);

/// The view along +k: columns (x, y) are the grid coordinates k + 1 and k + 2, so that a vertex is snapped alike in the
/// two views that share a coordinate.
LayeredView axis_view(const AbufferGrid& grid, int k, uint32_t classes);

/// Bricks of 64 voxels.
size_t brick_count(const AbufferGrid& grid);

/// Whether voxels that parity searches have reaches (ABUFFER_REACHES): up to 2²⁰ voxels, of eight bytes each; more
/// would take more time to build than rays gain.
bool keeps_reaches(const AbufferGrid& grid);

/// Pixels of the A-buffer of axis k.
uint32_t axis_pixels(const AbufferGrid& grid, int k);

}  // namespace lucarium::abuffer
