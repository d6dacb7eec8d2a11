// SPDX-License-Identifier: Apache-2.0
// The smallest whole consumer of tiles.clh: per pixel, how many gaps lie between consecutive fragments
// and the sum of a payload (a barycentric weight in 1/4096) over the fragments.
typedef struct Gaps {
  __global uint* gaps;  // [pixel]
  __global uint* sums;  // [pixel]
  uint width;
} Gaps;
typedef struct Weight {
  float4 plane;
} Weight;
#define LAYERED_CONSUMER Gaps
#define LAYERED_NARROW
#define LAYERED_PAYLOAD Weight
#include "lucarium/services/layered_raster/tiles.clh"

Weight layered_payload(Gaps* gaps, uint triangle, const LayeredPlanes* planes) {
  const Weight weight = {planes->b1 * 4096.0f};
  return weight;
}

LayeredUint layered_payload_row(const Weight* weight, float row, LayeredFloat w) {
  const LayeredFloat value = layered_plane(weight->plane, row) * w;
  return layered_to_uint(value > 0.0f ? value : (LayeredFloat)(0.0f));
}

LayeredHalfUint layered_payload_half(const Weight* weight, LayeredHalfFloat lane, float row, LayeredHalfFloat w) {
  const LayeredHalfFloat value = layered_half_plane(weight->plane, lane, row) * w;
  return layered_half_to_uint(value > 0.0f ? value : (LayeredHalfFloat)(0.0f));
}

void layered_prepare(Gaps* gaps, LayeredRow* row) {}

void layered_consume(Gaps* gaps, const LayeredRow* row) {
  const uint first = row->y * gaps->width + row->x;
  // Every fragment; a part that goes on repeats the last one of the part before.
  for (uint layer = row->part & LAYERED_PART_FIRST ? 0u : 1u; layer < row->count; ++layer)
    for (uint lanes = layered_present(row, layer); lanes; lanes &= lanes - 1u) {
      const uint lane = layered_first(lanes);
      gaps->sums[first + lane] += layered_at(row, layer, lane);
    }
  // Every gap between a fragment and the next.
  for (uint layer = 1u; layer < row->count; ++layer)
    for (uint lanes = layered_present(row, layer); lanes; lanes &= lanes - 1u)
      ++gaps->gaps[first + layered_first(lanes)];
}

__kernel void find_gaps(LAYERED_TILE_PARAMETERS __global uint* gaps, __global uint* sums) {
  Gaps consumer = {gaps, sums, layered_views[layered_view].width};
  LAYERED_RUN_TILES(&consumer);
}
