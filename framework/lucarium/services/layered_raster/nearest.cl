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

// What a row of tiles holds where nothing is seen.
void layered_clear_nearest(LayeredNearest* nearest, uint height, uint row) {
  const uint end = min((row + 1u) * LAYERED_TILE_ROWS, height) * nearest->width;
  uint i = row * LAYERED_TILE_ROWS * nearest->width;
  for (; i + 8u <= end; i += 8u) {
    vstore8((float8)(INFINITY), 0, nearest->depth + i);
    vstore8((uint8)(0xffffffffu), 0, nearest->triangle + i);
  }
  for (; i < end; ++i) {
    nearest->depth[i] = INFINITY;
    nearest->triangle[i] = 0xffffffffu;
  }
}

__kernel void layered_store_nearest(LAYERED_TILE_PARAMETERS __global float* depth, __global uint* triangle) {
  LayeredNearest nearest = {depth, triangle, layered_views[layered_view].width};
  layered_clear_nearest(&nearest, layered_views[layered_view].height, LAYERED_TILE_ROW);
  LAYERED_RUN_TILES(&nearest);
}
