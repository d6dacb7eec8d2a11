// SPDX-License-Identifier: Apache-2.0
// Per row of lanes the sum of hashes of what layered_walk_pairs() reports.
#include "lucarium/shared/hash.h"

typedef struct Events {
  __global uint* sums;
  uint width, pixel;
  uint backs, sheets;
} Events;
typedef struct Number {
  uint triangle;
} Number;
#define LAYERED_CONSUMER Events
#define LAYERED_PAYLOAD Number
#include "lucarium/services/layered_raster/pairs.clh"

Number layered_payload(Events* events, uint triangle, const LayeredPlanes* planes) {
  const Number number = {triangle & ~LAYERED_AWAY};
  return number;
}
LayeredUint layered_payload_row(const Number* number, float row, LayeredFloat w) {
  return (LayeredUint)(number->triangle);
}
void layered_prepare(Events* events, LayeredRow* row) {}

// Events do not say which lane they are of: their sum goes to the first pixel of the row.
void layered_consume(Events* events, const LayeredRow* row) {
  events->pixel = row->y * events->width + row->x;
  layered_walk_pairs(events, row);
}
void layered_ray_begins(Events* events, uint2 pixel, uint payload, bool front) {
  events->sums[events->pixel] += hash_uint3(1u, payload, front);
}
void layered_ray_crosses(Events* events, LayeredGap gap) {
  events->sums[events->pixel] += hash_uint3(hash_uint2(2u, gap.near), gap.far, gap.near_front * 2u + gap.far_front);
}
void layered_ray_ends(Events* events, uint2 pixel, uint payload, bool front) {
  events->sums[events->pixel] += hash_uint3(3u, payload, front);
}
bool layered_backs_matter(const Events* events) { return events->backs; }
bool layered_are_sheets(const Events* events, uint near, uint far) {
  return events->sheets && near % 7u != 0u && far % 7u != 0u;
}
bool layered_in_one_place(const Events* events, LayeredGap gap) {
  return gap.length <= 1u && layered_are_sheets(events, gap.near, gap.far);
}

__kernel void sum_events(LAYERED_TILE_PARAMETERS uint backs, uint sheets, __global uint* sums) {
  Events events = {sums, layered_views[layered_view].width, 0u, backs, sheets};
  LAYERED_RUN_TILES(&events);
}
