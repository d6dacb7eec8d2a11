// SPDX-License-Identifier: Apache-2.0
// Keeps the rows of bundles (kept_rows.clh) in one list of words: the words of each row of tiles are counted, given a
// place where all of the view still fit, and written.
#include "lucarium/shared/scene_types.h"
#include "lucarium/shared/surface_atlas.h"

typedef struct KeptBundle {
  const __global AtlasTriangle* atlas_triangles;
  const __global uint* atlas_table;
  uint double_sided;
  __global uint* words;  // where the next row goes; null: rows are counted
  uint count;
} KeptBundle;

#define BUNDLE_PAIRS KeptBundle
#define BUNDLE_CONSUMES_ROWS
#include "lucarium/services/texel_sides/bundle_pairs.clh"

void bundle_expect(KeptBundle* kept, uint texel) {}

#include "lucarium/services/layered_raster/kept_rows.clh"

void layered_expect(KeptBundle* kept, uint payload) {}

void layered_consume(KeptBundle* kept, const LayeredRow* row) {
  if (kept->words) keep_row(row, kept->words + kept->count);
  kept->count += kept_row_words(row);
}

// counts: words of each row of tiles.
__kernel void count_kept_rows(LAYERED_TILE_PARAMETERS AtlasInfo atlas_info,
                              __global const AtlasTriangle* atlas_triangles, __global const uint* atlas_table,
                              uint rows, __global uint* counts) {
  KeptBundle kept = {atlas_triangles, atlas_table, atlas_info.double_sided_count, 0, 0u};
  LAYERED_RUN_TILES(&kept);
  if (LAYERED_TILE_ROW < rows) counts[LAYERED_TILE_ROW] = kept.count;
}

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

__kernel void keep_rows(LAYERED_TILE_PARAMETERS AtlasInfo atlas_info, __global const AtlasTriangle* atlas_triangles,
                        __global const uint* atlas_table, uint rows, uint view, __global const uint* starts,
                        __global uint* words) {
  const uint row = LAYERED_TILE_ROW;
  if (row >= rows) return;
  const uint start = starts[(size_t)view * (rows + 1u) + row];
  if (start == LUCARIUM_NONE) return;
  KeptBundle kept = {atlas_triangles, atlas_table, atlas_info.double_sided_count, words + start, 0u};
  LAYERED_RUN_TILES(&kept);
}
