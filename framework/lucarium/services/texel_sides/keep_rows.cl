// SPDX-License-Identifier: Apache-2.0
// Keeps the rays of bundles (kept_rows.clh) in one list of words: the words of each row of tiles are counted, given a
// place where all of the view still fit, and written. How many there are depends on the last bits of floats: one kernel
// counts and writes, so that both see the same bits.
#include "lucarium/services/texel_sides/bundle_sheets.clh"
#include "lucarium/shared/scene_types.h"
#include "lucarium/shared/surface_atlas.h"

typedef struct KeptBundle {
  const __global AtlasTriangle* atlas_triangles;
  const __global uint* atlas_table;
  uint double_sided;
  BundleSheets sheets;
  const __global uint* accessibility;
  const __global float2* interior;  // y: what a ray counts that meets a back
  const __global uint* covered;     // which parts belong to the covered half of their side; null: there are no halves
  uint sides;
  __global uint* words;     // where the view's row of tiles begins; null: words are counted
  uint count;               // of its words so far
  uint begins, gaps, ends;  // of the row of pixels
} KeptBundle;

#define BUNDLE_PAIRS KeptBundle
#define BUNDLE_CONSUMES_ROWS
#include "lucarium/services/texel_sides/kept_rows.clh"

void bundle_expect(KeptBundle* kept, uint texel) {}

void keep_word(KeptBundle* kept, uint word) {
  if (kept->words) kept->words[kept->count] = word;
  ++kept->count;
}

uint keep_end(const KeptBundle* kept, FragmentSide end) {
  const uint half_side = kept->covered ? half_of_part(kept->covered, kept->sides, end.side, end.part) : end.side;
  return half_side | part_level(kept->accessibility, end.side, end.part) << KEPT_HALF_BITS;
}

void layered_ray_begins(KeptBundle* kept, uint2 pixel, uint payload, bool front) {
  const FragmentSide end = fragment_side(kept, payload, front);
  if (end.side == LUCARIUM_NONE) return;
  keep_word(kept, keep_end(kept, end) | KEPT_IN_LANE(pixel));
  ++kept->begins;
}

void layered_ray_crosses(KeptBundle* kept, LayeredGap gap) {
  const FragmentSide near = fragment_side(kept, gap.near, gap.near_front);
  const FragmentSide far = fragment_side(kept, gap.far, gap.far_front);
  if (near.side == LUCARIUM_NONE && far.side == LUCARIUM_NONE) return;
  const uint backwards = near.side == LUCARIUM_NONE ? 1u : 0u;
  const FragmentSide first = backwards ? far : near;
  keep_word(kept, keep_end(kept, first) | KEPT_IN_LANE(gap.pixel));
  if (backwards || far.side == LUCARIUM_NONE)
    keep_word(kept, KEPT_BACK(backwards, kept->interior[first.side].y));
  else
    keep_word(kept, keep_end(kept, far) | KEPT_GAP);
  ++kept->gaps;
}

void layered_ray_ends(KeptBundle* kept, uint2 pixel, uint payload, bool front) {
  const FragmentSide end = fragment_side(kept, payload, front);
  if (end.side == LUCARIUM_NONE) return;
  keep_word(kept, keep_end(kept, end) | KEPT_IN_LANE(pixel));
  ++kept->ends;
}

void layered_consume(KeptBundle* kept, const LayeredRow* row) {
  const uint header = kept->count++;
  kept->begins = kept->gaps = kept->ends = 0u;
  layered_walk_pairs(kept, row);
  if (kept->count == header + 1u)
    kept->count = header;
  else if (kept->words)
    kept->words[header] =
        KEPT_HEADER(row->x / LAYERED_LANES, row->y % LAYERED_TILE_ROWS, kept->begins, kept->gaps, kept->ends);
}

// accessibility, interior, covered: of texel sides; two_halves: whether `covered` is.
#define KEEP_PARAMETERS                                                                                                \
  LAYERED_TILE_PARAMETERS AtlasInfo atlas_info, __global const AtlasTriangle *atlas_triangles,                         \
      __global const uint *atlas_table, __global const SurfacePoint *atlas_points, __global const uint *accessibility, \
      __global const float2 *interior, __global const uint *covered, uint two_halves, uint rows
#define KEEP_SET(kept, to)                                                      \
  KeptBundle kept = {atlas_triangles,                                           \
                     atlas_table,                                               \
                     atlas_info.double_sided_count,                             \
                     bundle_sheets(atlas_points, layered_views + layered_view), \
                     accessibility,                                             \
                     interior,                                                  \
                     two_halves ? covered : 0,                                  \
                     atlas_info.texel_count,                                    \
                     to,                                                        \
                     0u,                                                        \
                     0u,                                                        \
                     0u,                                                        \
                     0u}

// Work-item: one. starts: of each view rows + 1 entries, where its rows of tiles begin and end; LUCARIUM_NONE: the
// view does not fit behind the words that are taken.
__kernel void place_kept_rows(uint rows, uint view, uint capacity, __global const uint* restrict counts,
                              __global uint* restrict taken, __global uint* restrict starts) {
  if (get_global_id(0) > 0u) return;
  const uint begin = taken[0];
  uint left = capacity - begin, fits = 1u;
  for (uint row = 0u; row < rows && fits; ++row) {
    fits = counts[row] <= left;
    left -= fits ? counts[row] : 0u;
  }
  uint at = begin;
  for (uint row = 0u; row <= rows; ++row) {
    starts[(size_t)view * (rows + 1u) + row] = fits ? at : LUCARIUM_NONE;
    if (row < rows) at += counts[row];
  }
  if (fits) taken[0] = at;
}

// counts: words of each row of tiles; writes 0: they are counted. starts: place_kept_rows().
__kernel void keep_rows(KEEP_PARAMETERS, uint view, uint writes, __global const uint* starts, __global uint* counts,
                        __global uint* words) {
  const uint row = LAYERED_TILE_ROW;
  if (row >= rows) return;
  const uint start = starts[(size_t)view * (rows + 1u) + row];
  if (writes && start == LUCARIUM_NONE) return;
  KEEP_SET(kept, writes ? words + start : 0);
  LAYERED_RUN_TILES(&kept);
  if (!writes) counts[row] = kept.count;
}
