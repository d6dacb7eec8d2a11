// SPDX-License-Identifier: Apache-2.0
// The stored A-buffer: count the fragments of every pixel, and, with the counts scanned, write them sorted. With
// LAYERED_KEEP only as many as that are kept per pixel.
#ifndef LAYERED_DEPTH
#define LAYERED_DEPTH
#endif
#include "lucarium/shared/layered_raster.h"

typedef struct LayeredStore {
  __global const uint* pixel_start;
  __global LayeredFragment* fragments;
  uint width;
  uint written[16];  // fragments of the row's pixels so far
} LayeredStore;
#define LAYERED_CONSUMER LayeredStore
#define LAYERED_STORES  // rows with more layers than fit: crowded_rows.clh
#define LAYERED_NARROW
#define LAYERED_PAYLOAD uint
#include "lucarium/services/layered_raster/tiles.clh"

uint layered_payload(LayeredStore* store, uint triangle, const LayeredPlanes* planes) { return triangle; }
LayeredUint layered_payload_row(const uint* triangle, float row, LayeredFloat w) { return (LayeredUint)(*triangle); }
LayeredHalfUint layered_payload_half(const uint* triangle, LayeredHalfFloat lane, float row, LayeredHalfFloat w) {
  return (LayeredHalfUint)(*triangle);
}
void layered_prepare(LayeredStore* store, LayeredRow* row) {}

void layered_consume(LayeredStore* store, const LayeredRow* row) {
  for (uint lane = 0u; lane < LAYERED_LANES; ++lane) store->written[lane] = 0u;
  __global const uint* starts = store->pixel_start + row->y * store->width + row->x;
  for (uint layer = 0u; layer < row->count; ++layer)
    for (uint rest = layered_present(row, layer); rest; rest &= rest - 1u) {
      const uint lane = layered_first(rest), place = layered_key(row, layer, lane) & LAYERED_KEY_LAYER;
      LayeredFragment fragment;
      fragment.triangle = ((const uint*)row->payload)[place * LAYERED_LANES + lane];
      fragment.depth = ((const float*)row->depth)[place * LAYERED_LANES + lane];
      store->fragments[starts[lane] + store->written[lane]++] = fragment;
    }
}

__kernel void layered_store_fragments(LAYERED_TILE_PARAMETERS __global const uint* pixel_start,
                                      __global LayeredFragment* fragments) {
  LayeredStore store;
  store.pixel_start = pixel_start;
  store.fragments = fragments;
  store.width = layered_views[layered_view].width;
  LAYERED_RUN_TILES(&store);
}

static void layered_count_triangle(const LayeredTiles* tiles, uint index, int px, int py, LayeredInt* counts) {
  const LayeredRecord r = layered_record(tiles, index);
  LayeredWalk walk = layered_walk(tiles, &r, px, py);
  for (uint row = walk.first; row <= walk.last; ++row) {
    LayeredInt uncovered = walk.e0 | walk.e1 | walk.e2 | walk.outside;
    walk.e0 += walk.step_y.x;
    walk.e1 += walk.step_y.y;
    walk.e2 += walk.step_y.z;
#ifdef LAYERED_ALPHA
    const uint mask = ~layered_signs(uncovered) & LAYERED_ALL_LANES;
    if (mask && (r.flags & LAYERED_RECORD_ALPHA)) {
      LayeredFloat w;
      layered_row_depth(&walk, (float)row, &w);
      uncovered = ~layered_lanes_of(
          layered_alpha(tiles, &walk, r.triangle & ~LAYERED_AWAY, mask, (float)row, w, (uint)px, (uint)py + row));
    }
#endif
    counts[row] -= uncovered >= 0;
  }
}

// pixel_counts: width × height and one more, which becomes 0. dropped: per row of tiles, fragments not kept.
__kernel void layered_count_fragments(LAYERED_TILE_PARAMETERS __global uint* pixel_counts, __global uint* dropped) {
  LayeredTiles tiles;
  LAYERED_SET_TILES(tiles);
  const uint width = tiles.view->width, height = tiles.view->height;
  const uint tiles_x = (width + LAYERED_LANES - 1u) / LAYERED_LANES;
  const uint row_of_tiles = LAYERED_TILE_ROW;
  const int py = (int)(row_of_tiles * LAYERED_TILE_ROWS);
  if (py >= (int)height) return;
  if (py == 0) pixel_counts[width * height] = 0u;
  uint lost = 0u;
  for (uint tile = 0u; tile < tiles_x; ++tile) {
    LayeredInt counts[LAYERED_TILE_ROWS];
    for (uint row = 0u; row < LAYERED_TILE_ROWS; ++row) counts[row] = 0;
    const uint first = layered_starts[row_of_tiles * tiles_x + tile];
    const uint end = layered_starts[row_of_tiles * tiles_x + tile + 1u];
    // Count the fragments of all triangles over the tile, a row of pixels at once.
    for (uint i = first; i < end; ++i)
      layered_count_triangle(&tiles, layered_pairs[i], (int)(tile * LAYERED_LANES), py, counts);
    // Write the pixels that lie in the image, and of each no more than is kept.
    for (uint row = 0u; row < min(LAYERED_TILE_ROWS, height - (uint)py); ++row) {
      const uint px = tile * LAYERED_LANES;
      for (uint lane = 0u; lane < min((uint)LAYERED_LANES, width - px); ++lane) {
        const uint count = (uint)((const int*)&counts[row])[lane];
#ifdef LAYERED_KEEP
        const uint kept = min(count, (uint)LAYERED_KEEP);
#else
        const uint kept = count;
#endif
        pixel_counts[((uint)py + row) * width + px + lane] = kept;
        lost += count - kept;
      }
    }
  }
  dropped[row_of_tiles] = lost;
}
