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

#if LAYERED_LANES == 16
#define abuffer_to_float convert_float16
#else
#define abuffer_to_float convert_float8
#endif
ABUFFER_DEFINE_INTERVAL(abuffer_intervals, LayeredFloat, LayeredUint, abuffer_to_float, layered_to_uint)

uint layered_payload(AbufferNobody* nobody, uint triangle, const LayeredPlanes* planes) { return triangle; }
LayeredUint layered_payload_row(const uint* triangle, float row, LayeredFloat w) { return (LayeredUint)(*triangle); }
void layered_prepare(AbufferNobody* nobody, LayeredRow* row) {}
void layered_consume(AbufferNobody* nobody, const LayeredRow* row) {}

// Parts of the indices of a tile's columns (abuffer_column()) for its lanes.
static void abuffer_lane_columns(uint4 voxels, uint px, uint lanes, uint* columns) {
  for (uint lane = 0u; lane < lanes; ++lane) columns[lane] = abuffer_column_in_row(voxels, px + lane);
}

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
    const uint lanes = min((uint)LAYERED_LANES, width - px);
    uint in_row[LAYERED_LANES];
    abuffer_lane_columns(grid.voxels, px, lanes, in_row);
    for (uint row = 0u; row < min(LAYERED_TILE_ROWS, height - py); ++row) {
      const uint of_row = abuffer_column_of_row(grid.voxels, axis, py + row);
      for (uint lane = 0u; lane < lanes; ++lane)
        abuffer_columns[of_row + in_row[lane]] = (uint)((const int*)&counts[row])[lane];
    }
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
    // Find where the lists of the tile's columns begin.
    uint places[LAYERED_TILE_ROWS][LAYERED_LANES];
    const uint lanes = min((uint)LAYERED_LANES, width - px);
    uint in_row[LAYERED_LANES];
    abuffer_lane_columns(grid.voxels, px, lanes, in_row);
    for (uint row = 0u; row < min(LAYERED_TILE_ROWS, height - py); ++row) {
      const uint of_row = abuffer_column_of_row(grid.voxels, axis, py + row);
      for (uint lane = 0u; lane < lanes; ++lane)
        places[row][lane] = start[of_row + in_row[lane]] = base + abuffer_columns[of_row + in_row[lane]];
    }
    const uint end = layered_starts[row_of_tiles * tiles_x + tile + 1u];
    for (uint i = layered_starts[row_of_tiles * tiles_x + tile]; i < end; ++i) {
      const LayeredRecord r = layered_record(&tiles, layered_pairs[i]);
      LayeredWalk walk = layered_walk(&tiles, &r, (int)px, (int)py);
      // Walk over the rows that the triangle touches.
      const uint triangle = r.triangle & ~LAYERED_AWAY;
      const AbufferPlane plane = abuffer_planes[triangle];
      for (uint row = walk.first; row <= walk.last; ++row) {
        uint mask = ~layered_signs(walk.e0 | walk.e1 | walk.e2 | walk.outside) & LAYERED_ALL_LANES;
        walk.e0 += walk.step_y.x;
        walk.e1 += walk.step_y.y;
        walk.e2 += walk.step_y.z;
        if (!mask) continue;
        // Write a fragment into every column that it touches.
        const LayeredUint intervals =
            abuffer_intervals(&plane, LAYERED_LANE_FLOAT + ((float)px + 0.5f), (float)(py + row) + 0.5f, grid.slack);
        for (; mask; mask &= mask - 1u) {
          const uint lane = layered_first(mask), place = places[row][lane]++;
          abuffer_depths[place] = ((const uint*)&intervals)[lane];
          abuffer_fragments[place] = triangle;
        }
      }
    }
  }
  if (row_of_tiles == 0u) start[width * height] = abuffer_counts[first + axis + 1u];
}
