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

#ifdef LAYERED_HALVES
ABUFFER_DEFINE_INTERVAL(abuffer_half_intervals, LayeredHalfFloat, LayeredHalfUint, convert_float8, layered_half_to_uint)
#endif

uint layered_payload(AbufferNobody* nobody, uint triangle, const LayeredPlanes* planes) { return triangle; }
LayeredUint layered_payload_row(const uint* triangle, float row, LayeredFloat w) { return (LayeredUint)(*triangle); }
void layered_prepare(AbufferNobody* nobody, LayeredRow* row) {}
void layered_consume(AbufferNobody* nobody, const LayeredRow* row) {}

// Parts of the indices of a tile's columns (abuffer_column()) for its lanes.
static void abuffer_lane_columns(uint4 voxels, uint px, uint lanes, uint* columns) {
  for (uint lane = 0u; lane < lanes; ++lane) columns[lane] = abuffer_column_in_row(voxels, px + lane);
}

#ifdef LAYERED_HALVES
// A triangle within half of a tile's columns, as most are, whose rows are one vector instead of two.
typedef struct AbufferHalfWalk {
  LayeredHalfInt e0, e1, e2, outside;
  int4 step_y;
  uint first, last, part;
} AbufferHalfWalk;

static bool abuffer_is_narrow(const LayeredRecord* r, int px) {
  const int first_x = max((r->x.w & 0xffff) - px, 0), last_x = min((int)((uint)r->x.w >> 16) - px, LAYERED_LANES - 1);
  return (first_x ^ last_x) < 8;
}

__attribute__((always_inline)) static AbufferHalfWalk abuffer_half_walk(const LayeredTiles* tiles,
                                                                        const LayeredRecord* r, int px, int py) {
  const LayeredWalk walk = layered_walk(tiles, r, px, py);
  const int first_x = (r->x.w & 0xffff) - px, last_x = (int)((uint)r->x.w >> 16) - px;
  AbufferHalfWalk half_walk;
  half_walk.part = (uint)max(first_x, 0) / 8u;
  const LayeredHalfInt lane = (LayeredHalfInt)(0, 1, 2, 3, 4, 5, 6, 7) + (int)(8u * half_walk.part);
  half_walk.e0 = walk.start.x + walk.step_x.x * lane;
  half_walk.e1 = walk.start.y + walk.step_x.y * lane;
  half_walk.e2 = walk.start.z + walk.step_x.z * lane;
  half_walk.outside = (lane - first_x) | (last_x - lane);
  half_walk.step_y = walk.step_y;
  half_walk.first = walk.first;
  half_walk.last = walk.last;
  return half_walk;
}
#endif

#define ABUFFER_NEXT_ROW(walk)  \
  (walk).e0 += (walk).step_y.x; \
  (walk).e1 += (walk).step_y.y; \
  (walk).e2 += (walk).step_y.z

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
#ifdef LAYERED_HALVES
      if (abuffer_is_narrow(&r, (int)px)) {
        AbufferHalfWalk walk = abuffer_half_walk(&tiles, &r, (int)px, (int)py);
        for (uint row = walk.first; row <= walk.last; ++row) {
          ((LayeredHalfInt*)&counts[row])[walk.part] -= (walk.e0 | walk.e1 | walk.e2 | walk.outside) >= 0;
          ABUFFER_NEXT_ROW(walk);
        }
        continue;
      }
#endif
      LayeredWalk walk = layered_walk(&tiles, &r, (int)px, (int)py);
      for (uint row = walk.first; row <= walk.last; ++row) {
        counts[row] -= (walk.e0 | walk.e1 | walk.e2 | walk.outside) >= 0;
        ABUFFER_NEXT_ROW(walk);
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

// Writes a fragment into every column of `mask`.
#define ABUFFER_WRITE(mask, intervals, places)                       \
  for (uint left = mask; left; left &= left - 1u) {                  \
    const uint lane = layered_first(left), place = (places)[lane]++; \
    abuffer_depths[place] = ((const uint*)&(intervals))[lane];       \
    abuffer_fragments[place] = triangle;                             \
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
      const uint triangle = r.triangle & ~LAYERED_AWAY;
      const AbufferPlane plane = abuffer_planes[triangle];
#ifdef LAYERED_HALVES
      if (abuffer_is_narrow(&r, (int)px)) {
        AbufferHalfWalk walk = abuffer_half_walk(&tiles, &r, (int)px, (int)py);
        const LayeredHalfFloat x = (LayeredHalfFloat)(0, 1, 2, 3, 4, 5, 6, 7) + ((float)(px + 8u * walk.part) + 0.5f);
        for (uint row = walk.first; row <= walk.last; ++row) {
          const uint mask = ~layered_signs8(walk.e0 | walk.e1 | walk.e2 | walk.outside) & 0xffu;
          ABUFFER_NEXT_ROW(walk);
          if (!mask) continue;
          const LayeredHalfUint intervals = abuffer_half_intervals(&plane, x, (float)(py + row) + 0.5f, grid.slack);
          ABUFFER_WRITE(mask, intervals, places[row] + 8u * walk.part);
        }
        continue;
      }
#endif
      LayeredWalk walk = layered_walk(&tiles, &r, (int)px, (int)py);
      for (uint row = walk.first; row <= walk.last; ++row) {
        const uint mask = ~layered_signs(walk.e0 | walk.e1 | walk.e2 | walk.outside) & LAYERED_ALL_LANES;
        ABUFFER_NEXT_ROW(walk);
        if (!mask) continue;
        const LayeredUint intervals =
            abuffer_intervals(&plane, LAYERED_LANE_FLOAT + ((float)px + 0.5f), (float)(py + row) + 0.5f, grid.slack);
        ABUFFER_WRITE(mask, intervals, places[row]);
      }
    }
  }
  if (row_of_tiles == 0u) start[width * height] = abuffer_counts[first + axis + 1u];
}
