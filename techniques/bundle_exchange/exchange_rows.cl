// SPDX-License-Identifier: Apache-2.0
// The exchange itself: a row of rays along omega, with their fragments in the order in which omega meets them.
// Consecutive fragments see each other: the side of the nearer one that faces omega, and the side of the farther one
// that faces -omega. Each receives what the other sends. Ends of rays see the environment. A side that does not reflect
// (the back of a single-sided surface) sends nothing, but what sees it has seen black: that counts.
#include "bundle_exchange/exchange_layout.clh"
#include "lucarium/shared/surface_atlas.h"

typedef struct Exchange {
  const global AtlasTriangle* atlas_triangles;
  const global uint* atlas_table;
  global float4* records;
  float3 from_near, from_far;  // radiance that enters the scene along omega and along -omega [cd/m^2]
  const global float2* exposure;  // y: what a ray counts that meets a back
  float weight;                // w of exchange_layout.clh
  uint double_sided;           // texels that have a back
} Exchange;

#include "lucarium/services/layered_raster_atlas.clh"
#define LAYERED_CONSUMER Exchange
#define LAYERED_EARLY
#define LAYERED_PAYLOAD LayeredAtlasCell
#include "lucarium/services/layered_raster_tiles.clh"

// What is to be read soon.
void layered_announce(Exchange* exchange, uint triangle) { LUCARIUM_PREFETCH(exchange->atlas_triangles + triangle); }
void layered_touch(Exchange* exchange, uint first, uint last) {
  LUCARIUM_PREFETCH(exchange->atlas_table + first);
  LUCARIUM_PREFETCH(exchange->atlas_table + last);
}

LayeredAtlasCell layered_payload(Exchange* exchange, uint triangle, const LayeredPlanes* planes) {
  return layered_atlas_begin(exchange->atlas_triangles, triangle & ~LAYERED_AWAY, planes);
}
LayeredUint layered_payload_row(const LayeredAtlasCell* cell, float row, LayeredFloat w) {
  return layered_atlas_cells(cell, row, w);
}
// Cells become texels, and what the row will touch is asked for.
void layered_prepare(Exchange* exchange, LayeredRow* row) {
  for (uint place = 0u; place < row->count; ++place) {
    uint* payload = (uint*)(row->payload + place);
    for (uint lanes = row->lanes[place]; lanes; lanes &= lanes - 1u) {
      const uint lane = layered_first(lanes), texel = exchange->atlas_table[payload[lane]];
      payload[lane] = texel;
      LUCARIUM_PREFETCH(exchange->records + (size_t)texel * BUNDLE_RECORD);
    }
  }
}

// The slot of a fragment that faces -omega (where the ray comes from), and the one that faces omega.
uint slot_towards(Exchange* exchange, uint texel, bool front_towards) {
  if (front_towards) return texel;
  return texel < exchange->double_sided ? texel + exchange->double_sided : LUCARIUM_NONE;
}
uint slot_away(Exchange* exchange, uint texel, bool front_towards) {
  return slot_towards(exchange, texel, !front_towards);
}

// A slot sees another, or the end of the ray. `end`: radiance there, in the channel of emission.
void receive(Exchange* exchange, uint receiver, uint sender, float3 end) {
  if (receiver == LUCARIUM_NONE) return;
  global float4* to = exchange->records + (size_t)receiver * BUNDLE_RECORD;
  const float w = exchange->weight;
  if (sender != LUCARIUM_NONE) {
    const global float4* from = exchange->records + (size_t)sender * BUNDLE_RECORD;
    to[0].w += w;
    to[1] += w * (float4)(from[0].xyz, 1.0f);
    for (uint channel = 1u; channel < BUNDLE_ACTIVE; ++channel) to[2u * channel + 1u].xyz += w * from[2u * channel].xyz;
  } else {
    to[1] += w * (float4)(end, 1.0f);
  }
}

// The ray of a slot ends at the back of a single-sided surface: black, and counted unless it began in a hidden place.
void meet_back(Exchange* exchange, uint receiver) {
  if (receiver == LUCARIUM_NONE) return;
  exchange->records[(size_t)receiver * BUNDLE_RECORD + 1u].w += exchange->weight * exchange->exposure[receiver].y;
}

// Two slots that see each other.
void exchange_pair(Exchange* exchange, uint a, uint b) {
  if (a == LUCARIUM_NONE) {
    meet_back(exchange, b);
  } else if (b == LUCARIUM_NONE) {
    meet_back(exchange, a);
  } else {
    receive(exchange, a, b, (float3)(0.0f));
    receive(exchange, b, a, (float3)(0.0f));
  }
}

// Lanes with a fragment in `layer` and one before it that may see each other. Without double-sided texels that leaves out
// gaps between two backs, most of them inside solids.
uint facing_lanes(const Exchange* exchange, const LayeredRow* row, uint layer) {
  const uint lanes = layered_present(row, layer);
  if (exchange->double_sided > 0u) return lanes;
  return lanes & (~layered_towards(row, layer - 1u) | layered_towards(row, layer));
}

void exchange_neighbours(Exchange* exchange, const LayeredRow* row, uint layer, uint lane) {
  const uint near_key = layered_key(row, layer - 1u, lane), far_key = layered_key(row, layer, lane);
  const bool near_towards = near_key & LAYERED_KEY_TOWARDS, far_towards = far_key & LAYERED_KEY_TOWARDS;
  // Surfaces drawn twice in one place are one: nothing lies between them.
  if ((near_key >> LAYERED_KEY_BUCKET) == (far_key >> LAYERED_KEY_BUCKET) && near_towards == far_towards) return;
  const uint a = slot_away(exchange, layered_at(row, layer - 1u, lane), near_towards);
  const uint b = slot_towards(exchange, layered_at(row, layer, lane), far_towards);
  exchange_pair(exchange, a, b);
}

void layered_consume(Exchange* exchange, const LayeredRow* row) {
  if (row->part & LAYERED_PART_FIRST)
    for (uint lanes = layered_present(row, 0u); lanes; lanes &= lanes - 1u) {
      const uint lane = layered_first(lanes);
      const bool towards = layered_key(row, 0u, lane) & LAYERED_KEY_TOWARDS;
      receive(exchange, slot_towards(exchange, layered_at(row, 0u, lane), towards), LUCARIUM_NONE, exchange->from_near);
    }
  for (uint layer = 1u; layer < row->count; ++layer)
    for (uint lanes = facing_lanes(exchange, row, layer); lanes; lanes &= lanes - 1u)
      exchange_neighbours(exchange, row, layer, layered_first(lanes));
  if (!(row->part & LAYERED_PART_LAST)) return;
  for (uint layer = 0u; layer < row->count; ++layer) {
    uint lanes = layered_present(row, layer);  // that end here
    if (layer + 1u < row->count) lanes &= ~layered_present(row, layer + 1u);
    for (; lanes; lanes &= lanes - 1u) {
      const uint lane = layered_first(lanes);
      const bool towards = layered_key(row, layer, lane) & LAYERED_KEY_TOWARDS;
      receive(exchange, slot_away(exchange, layered_at(row, layer, lane), towards), LUCARIUM_NONE, exchange->from_far);
    }
  }
}

// ends: radiance that enters along omega, and along -omega.
__kernel void exchange_rows(LAYERED_TILE_PARAMETERS AtlasInfo atlas_info,
                            __global const AtlasTriangle* atlas_triangles, __global const uint* atlas_table,
                            __global const float2* exposure, float weight, __global const float4* ends, __global float4* records) {
  Exchange exchange;
  exchange.atlas_triangles = atlas_triangles;
  exchange.atlas_table = atlas_table;
  exchange.records = records;
  exchange.from_near = ends[0].xyz;
  exchange.from_far = ends[1].xyz;
  exchange.exposure = exposure;
  exchange.weight = weight;
  exchange.double_sided = atlas_info.double_sided_count;
  LAYERED_RUN_TILES(&exchange);
}
