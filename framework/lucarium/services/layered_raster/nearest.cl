// SPDX-License-Identifier: Apache-2.0
// Depth and triangle of what is seen through every pixel. Compiled with LAYERED_KEEP = 1.
#ifndef LAYERED_KEEP
#define LAYERED_KEEP 1u
#endif
#ifndef LAYERED_DEPTH
#define LAYERED_DEPTH
#endif
#include "lucarium/shared/layered_raster.h"

typedef struct LayeredNearest {
  __global float* depth;
  __global uint* triangle;
  uint width;
} LayeredNearest;
#define LAYERED_CONSUMER LayeredNearest
#define LAYERED_PAYLOAD uint
#define LAYERED_NARROW
#include "lucarium/services/layered_raster/tiles.clh"

uint layered_payload(LayeredNearest* nearest, uint triangle, const LayeredPlanes* planes) { return triangle; }
LayeredUint layered_payload_row(const uint* triangle, float row, LayeredFloat w) { return (LayeredUint)(*triangle); }
#ifdef LAYERED_DRAWS_NARROW
LayeredHalfUint layered_payload_half(const uint* triangle, LayeredHalfFloat lane, float row, LayeredHalfFloat w) {
  return (LayeredHalfUint)(*triangle);
}
#endif
void layered_prepare(LayeredNearest* nearest, LayeredRow* row) {}

void layered_consume(LayeredNearest* nearest, const LayeredRow* row) {
  const uint first = row->y * nearest->width + row->x;
  for (uint lanes = row->lanes[0]; lanes; lanes &= lanes - 1u) {
    const uint lane = layered_first(lanes);
    nearest->triangle[first + lane] = ((const uint*)row->payload)[lane];
    nearest->depth[first + lane] = ((const float*)row->depth)[lane];
  }
}

// What a tile holds where nothing is seen.
void layered_clear_nearest(LayeredNearest* nearest, uint height, uint x, uint y) {
  const uint lanes = min((uint)LAYERED_LANES, nearest->width - x), end = min(y + LAYERED_TILE_ROWS, height);
  for (uint row = y; row < end; ++row) {
    __global float* depth = nearest->depth + row * nearest->width + x;
    __global uint* triangle = nearest->triangle + row * nearest->width + x;
    if (lanes == LAYERED_LANES) {
      for (uint lane = 0u; lane < LAYERED_LANES; lane += 8u) {
        vstore8((float8)(INFINITY), 0, depth + lane);
        vstore8((uint8)(0xffffffffu), 0, triangle + lane);
      }
      continue;
    }
    for (uint lane = 0u; lane < lanes; ++lane) {
      depth[lane] = INFINITY;
      triangle[lane] = 0xffffffffu;
    }
  }
}

__kernel void layered_store_nearest(LAYERED_TILE_PARAMETERS __global float* depth, __global uint* triangle) {
  const uint width = layered_views[layered_view].width, height = layered_views[layered_view].height;
  const uint tile = LAYERED_OWN_TILE, tiles_x = (width + LAYERED_LANES - 1u) / LAYERED_LANES;
  if (tile >= tiles_x * ((height + LAYERED_TILE_ROWS - 1u) / LAYERED_TILE_ROWS)) return;
  LayeredNearest nearest = {depth, triangle, width};
  layered_clear_nearest(&nearest, height, tile % tiles_x * LAYERED_LANES, tile / tiles_x * LAYERED_TILE_ROWS);
  LAYERED_RUN_TILE(&nearest, tile);
}
