// SPDX-License-Identifier: Apache-2.0
// A minimal two-way exchange: every pair of neighbouring fragments gives each other what they send, and counts.
#include "lucarium/shared/surface_atlas.h"

typedef struct Exchange {
  __global const AtlasTriangle* triangles;
  __global const uint* table;
  __global float4*
      sides;          // two per texel side, half a cache line: what it sends (4 halfs); what it received (rgb, count)
  uint double_sided;  // texels that have a back
} Exchange;

#include "lucarium/services/layered_raster/atlas.clh"
#define LAYERED_CONSUMER Exchange
#define LAYERED_EARLY
#define LAYERED_NARROW
#define LAYERED_PAYLOAD LayeredAtlasCell
#include "lucarium/services/layered_raster/tiles.clh"

void layered_prefetch(Exchange* exchange, uint triangle) { LUCARIUM_PREFETCH(exchange->triangles + triangle); }

void layered_touch(Exchange* exchange, uint first, uint last) {
  LUCARIUM_PREFETCH(exchange->table + first);
  LUCARIUM_PREFETCH(exchange->table + last);
}

LayeredAtlasCell layered_payload(Exchange* exchange, uint triangle, const LayeredPlanes* planes) {
  return layered_atlas_begin(exchange->triangles, triangle & ~LAYERED_AWAY, planes);
}

LayeredUint layered_payload_row(const LayeredAtlasCell* cell, float row, LayeredFloat w) {
  return layered_atlas_cells(cell, row, w);
}
LayeredHalfUint layered_payload_half(const LayeredAtlasCell* cell, LayeredHalfFloat lane, float row,
                                     LayeredHalfFloat w) {
  return layered_atlas_half_cells(cell, lane, row, w);
}

// The texel side of a texel's back.
static uint back_of(const Exchange* exchange, uint texel) {
  return texel < exchange->double_sided ? texel + exchange->double_sided : 0xffffffffu;
}

// Payloads become texels; asks for what the row will touch.
void layered_prepare(Exchange* exchange, LayeredRow* row) {
  for (uint place = 0u; place < row->count; ++place) {
    uint* payload = (uint*)(row->payload + place);
    for (uint lanes = row->lanes[place]; lanes; lanes &= lanes - 1u) {
      const uint lane = layered_first(lanes), texel = exchange->table[payload[lane]];
      payload[lane] = texel;
      LUCARIUM_PREFETCH(exchange->sides + 2u * texel);
    }
  }
}

void layered_consume(Exchange* exchange, const LayeredRow* row) {
  for (uint layer = 1u; layer < row->count; ++layer) {
    uint lanes = layered_present(row, layer);
    // Gaps between backs of single-sided surfaces, most of them inside solids.
    if (exchange->double_sided == 0u) lanes &= ~layered_towards(row, layer - 1u) | layered_towards(row, layer);
    for (; lanes; lanes &= lanes - 1u) {
      const uint lane = layered_first(lanes);
      const uint near_key = layered_key(row, layer - 1u, lane), far_key = layered_key(row, layer, lane);
      const uint near_texel = layered_at(row, layer - 1u, lane), far_texel = layered_at(row, layer, lane);
      const uint a = near_key & LAYERED_KEY_TOWARDS ? back_of(exchange, near_texel) : near_texel;
      const uint b = far_key & LAYERED_KEY_TOWARDS ? far_texel : back_of(exchange, far_texel);
      float4 from_a = (float4)(0.0f, 0.0f, 0.0f, 1.0f), from_b = from_a;
      if (a != 0xffffffffu) from_a = vload_half4(4u * a, (__global const half*)exchange->sides);
      if (b != 0xffffffffu) from_b = vload_half4(4u * b, (__global const half*)exchange->sides);
      if (a != 0xffffffffu) exchange->sides[2u * a + 1u] += from_b;
      if (b != 0xffffffffu) exchange->sides[2u * b + 1u] += from_a;
    }
  }
}

__kernel void exchange(LAYERED_TILE_PARAMETERS __global const AtlasTriangle* atlas_triangles,
                       __global const uint* atlas_table, __global float4* sides, uint double_sided) {
  Exchange consumer = {atlas_triangles, atlas_table, sides, double_sided};
  LAYERED_RUN_TILES(&consumer);
}
