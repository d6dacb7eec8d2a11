// SPDX-License-Identifier: Apache-2.0
// The exchange itself: a row of rays along omega, with their fragments in the order in which omega meets them.
// Consecutive fragments, nearest neighbours along the ray, see each other: the side of the nearer one that faces omega,
// and the side of the farther one that faces -omega. Each receives what the other sends, and counts it by how
// accessible its own part of the texel is. Ends of rays see the environment. A side that does not reflect (the back of
// a single-sided surface) sends nothing, but what sees it has seen black: that counts.
#include "bundle_exchange/base/exchange_layout.clh"
#include "lucarium/services/texel_sides/bundle_sheets.clh"
#include "lucarium/services/texel_sides/side_parts.clh"

typedef struct Exchange {
  const __global AtlasTriangle* atlas_triangles;
  const __global uint* atlas_table;
  const __global uint* accessibility;
  const __global float2* interior;  // y: what a ray counts that meets a back
  __global float4* records;
  float3 from_near, from_far;  // radiance that enters the scene along omega and along -omega [cd/m^2]
  float weight;                // w of exchange_layout.clh
  uint double_sided;           // texels that have a back
  BundleSheets sheets;
#ifdef SIDE_HALVES
  const __global uint* covered;  // which parts belong to the covered half of their side
  uint sides;                    // records of covered halves begin behind those of so many open ones
#endif
} Exchange;

#define BUNDLE_PAIRS Exchange
#include "lucarium/services/texel_sides/bundle_pairs.clh"

void bundle_expect(Exchange* exchange, uint texel) {
  LUCARIUM_PREFETCH(exchange->records + (size_t)texel * BUNDLE_RECORD);
  LUCARIUM_PREFETCH(exchange->accessibility + (size_t)texel * SIDE_PART_WORDS);
}

// The record of a side, or of that half of it that the part belongs to.
__global float4* record_of(const Exchange* exchange, FragmentSide end) {
#ifdef SIDE_HALVES
  const uint record = half_of_part(exchange->covered, exchange->sides, end.side, end.part);
#else
  const uint record = end.side;
#endif
  return exchange->records + (size_t)record * BUNDLE_RECORD;
}

// Weight of a ray at one of its ends.
float end_weight(const Exchange* exchange, FragmentSide end) {
  return exchange->weight * part_accessibility(exchange->accessibility, end.side, end.part);
}

// A texel side sees another, by their records, which counts the ray by `sender_weight`: equation 3 (Hermes et al. 2010)
// from sender x to receiver y. The cosine is implicit, since a texel side is met by as many rays as it shows area to
// omega; f_r follows when y sends (make_senders()), 2π = 1/p is in the weight, and 1/N in side_mean().
void receive(__global float4* to, float weight, const __global float4* from, float sender_weight) {
  to[0].w += sender_weight;
  to[1] += weight * (float4)(from[0].xyz, 1.0f);
  for (uint channel = 1u; channel < BUNDLE_ACTIVE; ++channel)
    to[2u * channel + 1u].xyz += weight * from[2u * channel].xyz;
}

// A texel side sees the end of the ray, where the environment is a light source like any (section 5.1): `radiance`
// there, in the channel of emission.
void receive_end(Exchange* exchange, FragmentSide end, float3 radiance) {
  if (end.side == LUCARIUM_NONE) return;
  record_of(exchange, end)[1] += end_weight(exchange, end) * (float4)(radiance, 1.0f);
}

// The ray of a texel side ends at the back of a single-sided surface: black, and counted unless it began in a hidden
// place.
void meet_back(Exchange* exchange, FragmentSide end) {
  if (end.side == LUCARIUM_NONE) return;
  record_of(exchange, end)[1].w += end_weight(exchange, end) * exchange->interior[end.side].y;
}

void layered_ray_begins(Exchange* exchange, uint2 pixel, uint payload, bool front) {
  receive_end(exchange, fragment_side(exchange, payload, front), exchange->from_near);
}

// Consecutive fragments of the pixel are opposite sampling points (section 4.2; x and y of figure 3). Both receive.
void layered_ray_crosses(Exchange* exchange, LayeredGap gap) {
  const FragmentSide near = fragment_side(exchange, gap.near, gap.near_front);
  const FragmentSide far = fragment_side(exchange, gap.far, gap.far_front);
  if (near.side == LUCARIUM_NONE || far.side == LUCARIUM_NONE) {
    meet_back(exchange, near.side == LUCARIUM_NONE ? far : near);
    return;
  }
  const float near_weight = end_weight(exchange, near), far_weight = end_weight(exchange, far);
  __global float4 *near_record = record_of(exchange, near), *far_record = record_of(exchange, far);
  receive(near_record, near_weight, far_record, far_weight);
  receive(far_record, far_weight, near_record, near_weight);
}

void layered_ray_ends(Exchange* exchange, uint2 pixel, uint payload, bool front) {
  receive_end(exchange, fragment_side(exchange, payload, front), exchange->from_far);
}

#ifdef SIDE_HALVES
#define EXCHANGE_HALVES_PARAMETER __global const uint *covered,
#else
#define EXCHANGE_HALVES_PARAMETER
#endif

// ends: radiance that enters along omega, and along -omega.
__kernel void exchange_pairs(LAYERED_TILE_PARAMETERS EXCHANGE_HALVES_PARAMETER AtlasInfo atlas_info,
                             __global const AtlasTriangle* atlas_triangles, __global const uint* atlas_table,
                             __global const SurfacePoint* atlas_points, __global const uint* accessibility,
                             __global const float2* interior, float weight, __global const float4* ends,
                             __global float4* records) {
  Exchange exchange;
  exchange.atlas_triangles = atlas_triangles;
  exchange.atlas_table = atlas_table;
  exchange.accessibility = accessibility;
  exchange.interior = interior;
  exchange.records = records;
  exchange.from_near = ends[0].xyz;
  exchange.from_far = ends[1].xyz;
  exchange.weight = weight;
  exchange.double_sided = atlas_info.double_sided_count;
  exchange.sheets = bundle_sheets(atlas_points, layered_views + layered_view);
#ifdef SIDE_HALVES
  exchange.covered = covered;
  exchange.sides = atlas_info.texel_count;
#endif
  LAYERED_RUN_TILES(&exchange);
}
