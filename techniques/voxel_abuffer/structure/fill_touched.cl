// SPDX-License-Identifier: Apache-2.0
// Exact lists straight from the tiles of LayeredRaster (conservative): fragments in every column that a triangle
// touches, counted, then written. Their order does not matter to exact search, so that nothing is sorted into layers:
// of small triangles a pixel row of a tile touches more than LAYERED_MAX_LAYERS, which LayeredRaster would peel.
#include "lucarium/shared/layered_raster.h"

typedef struct AbufferNobody {
  uint unused;
} AbufferNobody;
#define LAYERED_CONSUMER AbufferNobody
#define LAYERED_PAYLOAD uint
#include "lucarium/services/layered_raster/tiles.clh"
#include "voxel_abuffer/structure/intervals.clh"

uint layered_payload(AbufferNobody* nobody, uint triangle, const LayeredPlanes* planes) { return triangle; }
LayeredUint layered_payload_row(const uint* triangle, float row, LayeredFloat w) { return (LayeredUint)(*triangle); }
void layered_prepare(AbufferNobody* nobody, LayeredRow* row) {}
void layered_consume(AbufferNobody* nobody, const LayeredRow* row) {}

// The tiles of a work-item's row: `tile` and its first pixel (px, py).
#define ABUFFER_EACH_TILE                                                            \
  LayeredTiles tiles;                                                                \
  LAYERED_SET_TILES(tiles);                                                          \
  const AbufferGrid grid = abuffer_grid[0];                                          \
  const uint width = tiles.view->width, height = tiles.view->height;                 \
  const uint tiles_x = (width + LAYERED_LANES - 1u) / LAYERED_LANES;                 \
  const uint row_of_tiles = LAYERED_TILE_ROW, py = row_of_tiles * LAYERED_TILE_ROWS; \
  if (py >= height) return;                                                          \
  for (uint tile = 0u, px = 0u; tile < tiles_x; ++tile, px += LAYERED_LANES)

// abuffer_columns: fragments of each column, in the order of abuffer_column().
__kernel void abuffer_count_touched(LAYERED_TILE_PARAMETERS __global const AbufferGrid* abuffer_grid, uint axis,
                                    __global uint* abuffer_columns) {
  ABUFFER_EACH_TILE {
    LayeredInt counts[LAYERED_TILE_ROWS];
    for (uint row = 0u; row < LAYERED_TILE_ROWS; ++row) counts[row] = 0;
    const uint end = layered_starts[row_of_tiles * tiles_x + tile + 1u];
    for (uint i = layered_starts[row_of_tiles * tiles_x + tile]; i < end; ++i) {
      const LayeredRecord r = layered_record(&tiles, layered_pairs[i]);
      LayeredWalk walk = layered_walk(&tiles, &r, (int)px, (int)py);
      for (uint row = walk.first; row <= walk.last; ++row) {
        counts[row] -= (walk.e0 | walk.e1 | walk.e2 | walk.outside) >= 0;
        walk.e0 += walk.step_y.x;
        walk.e1 += walk.step_y.y;
        walk.e2 += walk.step_y.z;
      }
    }
    for (uint row = 0u; row < min(LAYERED_TILE_ROWS, height - py); ++row)
      for (uint lane = 0u; lane < min((uint)LAYERED_LANES, width - px); ++lane)
        abuffer_columns[abuffer_column(grid.voxels, axis, px + lane, py + row)] =
            (uint)((const int*)&counts[row])[lane];
  }
}

// abuffer_columns: scanned. Also writes where lists start. Where there is no room the host makes some, and builds
// again.
__kernel void abuffer_fill_touched(LAYERED_TILE_PARAMETERS __global const AbufferGrid* abuffer_grid, uint axis,
                                   __global const uint* abuffer_columns, __global const AbufferPlane* abuffer_planes,
                                   __global const uint* abuffer_counts, uint first, uint capacity,
                                   __global uint* abuffer_start, __global uint* abuffer_depths,
                                   __global uint* abuffer_fragments) {
  if (abuffer_counts[first + axis + 1u] > capacity) return;
  const uint base = abuffer_counts[first + axis];
  __global uint* start = abuffer_start + axis * abuffer_grid[0].bricks.w;
  ABUFFER_EACH_TILE {
    uint places[LAYERED_TILE_ROWS][LAYERED_LANES];
    for (uint row = 0u; row < min(LAYERED_TILE_ROWS, height - py); ++row)
      for (uint lane = 0u; lane < min((uint)LAYERED_LANES, width - px); ++lane) {
        const uint column = abuffer_column(grid.voxels, axis, px + lane, py + row);
        places[row][lane] = start[column] = base + abuffer_columns[column];
      }
    const uint end = layered_starts[row_of_tiles * tiles_x + tile + 1u];
    for (uint i = layered_starts[row_of_tiles * tiles_x + tile]; i < end; ++i) {
      const LayeredRecord r = layered_record(&tiles, layered_pairs[i]);
      LayeredWalk walk = layered_walk(&tiles, &r, (int)px, (int)py);
      const uint triangle = r.triangle & ~LAYERED_AWAY;
      const AbufferPlane plane = abuffer_planes[triangle];
      for (uint row = walk.first; row <= walk.last; ++row) {
        uint mask = ~layered_signs(walk.e0 | walk.e1 | walk.e2 | walk.outside) & LAYERED_ALL_LANES;
        walk.e0 += walk.step_y.x;
        walk.e1 += walk.step_y.y;
        walk.e2 += walk.step_y.z;
        for (; mask; mask &= mask - 1u) {
          const uint lane = layered_first(mask), place = places[row][lane]++;
          abuffer_depths[place] =
              abuffer_interval(&plane, (float)(px + lane) + 0.5f, (float)(py + row) + 0.5f, grid.slack);
          abuffer_fragments[place] = triangle;
        }
      }
    }
  }
  if (row_of_tiles == 0u) start[width * height] = abuffer_counts[first + axis + 1u];
}
