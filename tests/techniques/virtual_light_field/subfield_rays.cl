// SPDX-License-Identifier: Apache-2.0
// What the rays of a subfield meet: per pixel the number of fragments and a sum of hashes of their triangles and sides.
#include "lucarium/shared/hash.h"

typedef struct Met {
  __global uint* sums;  // two per pixel
  uint width;
} Met;
typedef struct Number {
  uint triangle;
} Number;
#define LAYERED_CONSUMER Met
#define LAYERED_PAYLOAD Number
#include "lucarium/services/layered_raster/tiles.clh"

Number layered_payload(Met* met, uint triangle, const LayeredPlanes* planes) {
  const Number number = {triangle};
  return number;
}
LayeredUint layered_payload_row(const Number* number, float row, LayeredFloat w) {
  return (LayeredUint)(number->triangle);
}
void layered_prepare(Met* met, LayeredRow* row) {}

void layered_consume(Met* met, const LayeredRow* row) {
  for (uint layer = row->part & LAYERED_PART_FIRST ? 0u : 1u; layer < row->count; ++layer)
    for (uint lanes = layered_present(row, layer); lanes; lanes &= lanes - 1u) {
      const uint lane = layered_first(lanes);
      __global uint* sum = met->sums + 2u * ((size_t)row->y * met->width + row->x + lane);
      sum[0] += 1u;
      sum[1] += hash_uint2(layered_at(row, layer, lane), layer);
    }
}

__kernel void sum_rays(LAYERED_TILE_PARAMETERS __global uint* sums) {
  Met met = {sums, layered_views[layered_view].width};
  LAYERED_RUN_TILES(&met);
}
