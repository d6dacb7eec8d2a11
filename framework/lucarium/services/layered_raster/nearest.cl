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
#include "lucarium/services/layered_raster/tiles.clh"

uint layered_payload(LayeredNearest* nearest, uint triangle, const LayeredPlanes* planes) { return triangle; }
LayeredUint layered_payload_row(const uint* triangle, float row, LayeredFloat w) { return (LayeredUint)(*triangle); }
void layered_prepare(LayeredNearest* nearest, LayeredRow* row) {}

void layered_consume(LayeredNearest* nearest, const LayeredRow* row) {
  const uint first = row->y * nearest->width + row->x;
  for (uint lanes = row->lanes[0]; lanes; lanes &= lanes - 1u) {
    const uint lane = layered_first(lanes);
    nearest->triangle[first + lane] = ((const uint*)row->payload)[lane];
    nearest->depth[first + lane] = ((const float*)row->depth)[lane];
  }
}

__kernel void layered_clear_nearest(__global float* depth, __global uint* triangle, uint pixels) {
  const uint i = get_global_id(0);
  if (i >= pixels) return;
  depth[i] = INFINITY;
  triangle[i] = 0xffffffffu;
}

__kernel void layered_store_nearest(LAYERED_TILE_PARAMETERS __global float* depth, __global uint* triangle) {
  LayeredNearest nearest = {depth, triangle, layered_views[layered_view].width};
  LAYERED_RUN_TILES(&nearest);
}
