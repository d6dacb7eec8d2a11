// SPDX-License-Identifier: Apache-2.0
// Transport along a line (Mortensen et al. 2007, section 3.3): a pixel of the subfield is a ray, whose radiance is the
// paper's radiance interface; the radiance that runs along it is what the last surface has sent, or the sky.
// Consecutive fragments see each other, as senders and receivers in both directions at once (section 3.2, figure 5).
// What arrives is added to the irradiance of texel sides and to the cells of facets.
#include "lucarium/compiler_hints.clh"
#include "lucarium/services/texel_sides/side_parts.clh"
#include "virtual_light_field/exchange/line_rows.clh"
#if defined(FIELD_PERTURBED) || defined(FIELD_LEVELS)
#define FIELD_POINTS
#include "virtual_light_field/exchange/perturbed_ends.clh"
#endif

typedef struct Exchange {
  LINE_ROWS_MEMBERS
  const __global uint* accessibility;
  const __global float2* interior;  // y: what a ray counts that meets a back
#ifdef SIDE_HALVES
  const __global uint* covered;  // which parts belong to the covered half of their side
  uint sides;                    // records of covered halves begin behind those of so many open ones
#endif
  __global float4* records;   // fold_sides.cl
  const __global uint* sent;  // RGB9E5 per cell: what leaves towards its direction, times scale
  float inverse_scale;
  float weight;                // solid angle that the rays of either direction stand for [sr]
  float3 from_near, from_far;  // radiance that enters the scene along omega and along -omega [cd/m^2]
#ifdef FIELD_MEDIA
  const __global float4* extinction;  // per texel side, of the volume behind it [1/m]
  float step;                         // of LAYERED_KEY_DEPTH [m]
#endif
#ifdef FIELD_POINTS
  PerturbedLine perturbed;
#endif
#ifndef FIELD_PERTURBED
  __global float4* received;  // of the line's cells: sum of radiance, rays
#endif
} Exchange;

#define BUNDLE_PAIRS Exchange
#include "virtual_light_field/exchange/line_sides.clh"

void bundle_expect(Exchange* exchange, uint texel) {
  LUCARIUM_PREFETCH(exchange->records + 2u * (size_t)texel);
  LUCARIUM_PREFETCH(exchange->accessibility + (size_t)texel * SIDE_PART_WORDS);
}

#include "lucarium/services/texel_sides/kept_rows.clh"

// Where a ray ends at a texel side.
typedef struct RayEnd {
  uint side;       // LUCARIUM_NONE: it is black
  uint half_side;  // which of its halves
  float accessibility;
} RayEnd;

RayEnd ray_end(const Exchange* exchange, uint payload, bool front) {
  const FragmentSide end = fragment_side(exchange, payload, front);
  RayEnd result = {end.side, end.side, 0.0f};
  if (end.side == LUCARIUM_NONE) return result;
#ifdef SIDE_HALVES
  result.half_side = half_of_part(exchange->covered, exchange->sides, end.side, end.part);
#endif
  result.accessibility = part_accessibility(exchange->accessibility, end.side, end.part);
  return result;
}

RayEnd kept_end(const Exchange* exchange, uint end) {
  RayEnd result = {KEPT_HALF(end), KEPT_HALF(end), level_accessibility(KEPT_LEVEL(end))};
#ifdef SIDE_HALVES
  if (result.side >= exchange->sides) result.side -= exchange->sides;
#endif
  return result;
}

// One end of a ray in the scene, with what it exchanges.
typedef struct FieldEnd {
  size_t record;  // of its half of a texel side
  uint cell;      // LUCARIUM_NONE: none
  float weight;   // what the ray counts in the irradiance of the side
  float3 leaves;  // radiance along the ray
#ifdef FIELD_LEVELS
  uint level, facet, backwards;  // level 0: it has a cell, or none
  float3 hit;
#endif
} FieldEnd;

// backwards: the side is seen from -omega.
LUCARIUM_FLATTEN FieldEnd field_end(const Exchange* exchange, RayEnd end, uint2 pixel, uint backwards) {
  FieldEnd result;
  result.cell = LUCARIUM_NONE;
  result.record = 2u * (size_t)end.half_side;
  const float4 record = exchange->records[result.record];
  result.weight = exchange->weight * end.accessibility;
  result.leaves = record.xyz;
#ifdef FIELD_LEVELS
  result.facet = as_uint(record.w);
  result.level = result.facet == LUCARIUM_NONE ? 0u : FIELD_MAP_LEVEL(exchange->maps[result.facet]);
  if (result.level > 0u) {
    result.backwards = backwards;
    result.hit = ray_hit(&exchange->perturbed, end.side, pixel);
    result.leaves += facet_radiance(&exchange->perturbed.field, exchange->sent, result.facet, result.hit,
                                    ray_towards(&exchange->perturbed, backwards));
    return result;
  }
#endif
#ifdef FIELD_PERTURBED
  const uint facet = as_uint(record.w);
  if (facet == LUCARIUM_NONE) return result;
  const float3 hit = ray_hit(&exchange->perturbed, end.side, pixel);
  result.cell = cell_of_point(&exchange->perturbed, facet, backwards, hit);
  result.leaves += facet_sends(&exchange->perturbed, exchange->sent, facet, result.cell, backwards, hit);
#else
  result.cell = line_cell(exchange, as_uint(record.w), pixel, backwards);
  if (result.cell != LUCARIUM_NONE) {
    const uint bits = exchange->sent[result.cell];
    if (bits != FIELD_NO_CELL) result.leaves += exchange->inverse_scale * unpack_rgb9e5(bits);
  }
#endif
  return result;
}

// `radiance` arrives; `rays`: what it counts of one.
void receive(Exchange* exchange, FieldEnd end, float3 radiance, float rays) {
  exchange->records[end.record + 1u] += end.weight * (float4)(radiance, rays);
#ifdef FIELD_LEVELS
  if (end.level > 0u)
    add_to_coarse_cells(&exchange->perturbed, end.facet, end.level, end.backwards, end.hit, radiance, rays);
#endif
  if (end.cell == LUCARIUM_NONE) return;
#ifdef FIELD_PERTURBED
  add_to_cell(&exchange->perturbed, end.cell - exchange->first_cell, radiance, rays);
#else
  exchange->received[end.cell - exchange->first_cell] += (float4)(radiance, rays);
#endif
}

// A ray from the sky.
void receive_outside(Exchange* exchange, RayEnd end, uint2 pixel, uint backwards) {
  receive(exchange, field_end(exchange, end, pixel, backwards), backwards ? exchange->from_near : exchange->from_far,
          1.0f);
}

LUCARIUM_FLATTEN void layered_ray_begins(Exchange* exchange, uint2 pixel, uint payload, bool front) {
  const RayEnd end = ray_end(exchange, payload, front);
  if (end.side != LUCARIUM_NONE) receive_outside(exchange, end, pixel, 1u);
}

LUCARIUM_FLATTEN void layered_ray_crosses(Exchange* exchange, LayeredGap gap) {
  const RayEnd near_end = ray_end(exchange, gap.near, gap.near_front);
  const RayEnd far_end = ray_end(exchange, gap.far, gap.far_front);
  if (near_end.side == LUCARIUM_NONE || far_end.side == LUCARIUM_NONE) {
    // The back of a single-sided surface: black, and counted unless the ray began in a hidden place.
    const uint backwards = near_end.side == LUCARIUM_NONE ? 1u : 0u;
    const RayEnd end = backwards ? far_end : near_end;
    if (end.side != LUCARIUM_NONE)
      receive(exchange, field_end(exchange, end, gap.pixel, backwards), (float3)(0.0f), exchange->interior[end.side].y);
    return;
  }
  const FieldEnd near = field_end(exchange, near_end, gap.pixel, 0u), far = field_end(exchange, far_end, gap.pixel, 1u);
  float3 to_near = far.leaves, to_far = near.leaves;
#ifdef FIELD_MEDIA
  // Where one looks into a volume, so does the other, though only its own walls know it (medium.clh).
  const float3 share = exp(-(float)gap.length * exchange->step *
                           fmax(exchange->extinction[near_end.side].xyz, exchange->extinction[far_end.side].xyz));
  to_near *= share;
  to_far *= share;
#endif
  receive(exchange, near, to_near, 1.0f);
  receive(exchange, far, to_far, 1.0f);
}

LUCARIUM_FLATTEN void layered_ray_ends(Exchange* exchange, uint2 pixel, uint payload, bool front) {
  const RayEnd end = ray_end(exchange, payload, front);
  if (end.side != LUCARIUM_NONE) receive_outside(exchange, end, pixel, 0u);
}

// The same of rays that are kept.
void kept_expect(Exchange* exchange, uint end) { LUCARIUM_PREFETCH(exchange->records + 2u * (size_t)KEPT_HALF(end)); }

LUCARIUM_FLATTEN void kept_ray_begins(Exchange* exchange, uint2 pixel, uint end) {
  receive_outside(exchange, kept_end(exchange, end), pixel, 1u);
}

LUCARIUM_FLATTEN void kept_ray_crosses(Exchange* exchange, uint2 pixel, uint near_end, uint far_end) {
  const FieldEnd near = field_end(exchange, kept_end(exchange, near_end), pixel, 0u);
  const FieldEnd far = field_end(exchange, kept_end(exchange, far_end), pixel, 1u);
  receive(exchange, near, far.leaves, 1.0f);
  receive(exchange, far, near.leaves, 1.0f);
}

LUCARIUM_FLATTEN void kept_ray_meets_back(Exchange* exchange, uint2 pixel, uint end, uint backwards, float share) {
  receive(exchange, field_end(exchange, kept_end(exchange, end), pixel, backwards), (float3)(0.0f), share);
}

LUCARIUM_FLATTEN void kept_ray_ends(Exchange* exchange, uint2 pixel, uint end) {
  receive_outside(exchange, kept_end(exchange, end), pixel, 0u);
}

// What both kernels take besides their rows. ends: radiance that enters along omega, and along -omega. received: of the
// line's cells float4 (sum of radiance, rays), or FIELD_FIXED_WORDS uints.
#ifdef FIELD_MEDIA
#define EXCHANGE_MEDIA_PARAMETER __global const float4 *extinction,
#define EXCHANGE_SET_MEDIA(exchange)   \
  (exchange)->extinction = extinction; \
  (exchange)->step = 1.0f / (layered_views[0].depth_scale * 4194304.0f);
#else
#define EXCHANGE_MEDIA_PARAMETER
#define EXCHANGE_SET_MEDIA(exchange)
#endif
#ifdef FIELD_PERTURBED
#define EXCHANGE_SUMS uint
#define EXCHANGE_LINE_SUMS received
#define EXCHANGE_SET_RECEIVED(exchange)
#else
#define EXCHANGE_SUMS float4
#define EXCHANGE_LINE_SUMS 0
#define EXCHANGE_SET_RECEIVED(exchange) (exchange)->received = received;
#endif
#ifdef FIELD_POINTS
// coarse: sums of cells from info.first_coarse on.
#define EXCHANGE_POINTS_PARAMETERS \
  __global const FieldLine *lines, __global const uint *nodes, uint cellwise, __global uint *coarse,
#define EXCHANGE_SET_SUMS(exchange)                                                                \
  const LightField field = {info, lines, nodes, 0, maps, tile_cells, inverse_scale, 0u};           \
  const PerturbedLine perturbed = {field,                                                          \
                                   subfield_of_view(layered_views[0]),                             \
                                   info.cell / (float)(1u << shift),                               \
                                   line,                                                           \
                                   cellwise,                                                       \
                                   1.0f / inverse_scale,                                           \
                                   atlas_points,                                                   \
                                   EXCHANGE_LINE_SUMS,                                             \
                                   coarse,                                                         \
                                   lines[line].omega.w * (float)(info.grid * info.grid) / M_PI_F}; \
  (exchange)->perturbed = perturbed;                                                               \
  EXCHANGE_SET_RECEIVED(exchange)
#else
#define EXCHANGE_POINTS_PARAMETERS
#define EXCHANGE_SET_SUMS(exchange) EXCHANGE_SET_RECEIVED(exchange)
#endif
#ifdef SIDE_HALVES
#define EXCHANGE_HALVES_PARAMETERS __global const uint *covered, uint sides,
#define EXCHANGE_SET_HALVES(exchange) \
  (exchange)->covered = covered;      \
  (exchange)->sides = sides;
#else
#define EXCHANGE_HALVES_PARAMETERS
#define EXCHANGE_SET_HALVES(exchange)
#endif
#define EXCHANGE_PARAMETERS                                                                                     \
  LINE_ROWS_PARAMETERS, __global const uint *accessibility, __global const float2 *interior, float weight,      \
      float inverse_scale, __global const float4 *ends,                                                         \
      EXCHANGE_MEDIA_PARAMETER EXCHANGE_POINTS_PARAMETERS EXCHANGE_HALVES_PARAMETERS __global const uint *sent, \
      __global float4 *records, __global EXCHANGE_SUMS *received
#define EXCHANGE_SET(exchange)               \
  LINE_ROWS_SET(exchange)                    \
  (exchange)->accessibility = accessibility; \
  (exchange)->interior = interior;           \
  (exchange)->records = records;             \
  (exchange)->sent = sent;                   \
  (exchange)->inverse_scale = inverse_scale; \
  (exchange)->weight = weight;               \
  (exchange)->from_near = ends[0].xyz;       \
  (exchange)->from_far = ends[1].xyz;        \
  EXCHANGE_SET_MEDIA(exchange)               \
  EXCHANGE_SET_HALVES(exchange)              \
  EXCHANGE_SET_SUMS(exchange)

__kernel LUCARIUM_FLATTEN void exchange_line(LAYERED_TILE_PARAMETERS EXCHANGE_PARAMETERS) {
  Exchange exchange;
  EXCHANGE_SET(&exchange);
  exchange.sheets = bundle_sheets(atlas_points, layered_views + layered_view);
  LAYERED_RUN_TILES(&exchange);
}

// The same of a line whose fragments are kept.
__kernel LUCARIUM_FLATTEN void exchange_kept_line(LAYERED_KEPT_PARAMETERS __global const LayeredView* layered_views,
                                                  EXCHANGE_PARAMETERS) {
  Exchange exchange;
  EXCHANGE_SET(&exchange);
  LAYERED_WALK_KEPT(&exchange);
}
