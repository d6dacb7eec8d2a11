// SPDX-License-Identifier: Apache-2.0
// Which triangles touch which tile, without atomics: LAYERED_CHUNKS work-items each count and later place a run of
// triangles, so that every tile's list is in the order of the triangles.
#include "lucarium/services/layered_raster/project.clh"
#ifndef LAYERED_CHUNKS
#define LAYERED_CHUNKS 16u
#endif

// Runs of elements: the bounds of `triangles` records without gaps, then those of `extra` (clipped parts).
typedef struct LayeredRun {
  uint first, end;
} LayeredRun;

static LayeredRun layered_run(uint chunk, uint count) {
  const uint size = (count + LAYERED_CHUNKS - 1u) / LAYERED_CHUNKS;
  const LayeredRun run = {min(chunk * size, count), min((chunk + 1u) * size, count)};
  return run;
}

static uint layered_bounds_of(__global const uint* bounds, __global const uint* extra_bounds, uint triangles, uint i) {
  return i < triangles ? bounds[i] : extra_bounds[i - triangles];
}

// Whether i begins a block of records (of `end`) of which none has bounds: those behind all that a view sees.
static bool layered_none_seen(__global const uint* bounds, uint i, uint end) {
  if ((i & 15u) != 0u || i + 16u > end) return false;
  const uint8 none = (uint8)(LAYERED_NO_BOUNDS), first = vload8(0, bounds + i), second = vload8(0, bounds + i + 8u);
  return layered_signs8(((first ^ none) | (second ^ none)) != 0u) == 0u;
}

#define LAYERED_EACH_TILE(bounds, tile)                                                                           \
  for (uint ty = (bounds) >> 8 & 0xffu; ty <= (bounds) >> 24; ++ty)                                               \
    for (uint tile = ty * tiles_x + ((bounds)&0xffu), end = ty * tiles_x + ((bounds) >> 16 & 0xffu); tile <= end; \
         ++tile)

// layered_histogram[chunk * stride + tile]; stride is a multiple of 16.
__kernel void layered_count_bins(__global const uint* layered_bounds, __global const uint* layered_extra_bounds,
                                 __global const uint* layered_clipped, uint triangles,
                                 __global const LayeredView* layered_views, uint layered_view, uint stride,
                                 __global uint* layered_histogram) {
  const uint tiles_x = (layered_views[layered_view].width + LAYERED_LANES - 1u) / LAYERED_LANES;
  const uint chunk = get_global_id(0);
  __global uint* counts = layered_histogram + chunk * stride;
  for (uint tile = 0u; tile < stride; tile += 16u) vstore16((uint16)(0u), 0, counts + tile);
  const LayeredRun run = layered_run(chunk, triangles + layered_clipped[0] * LAYERED_CLIP_PARTS);
  const uint whole = min(run.end, triangles);
  for (uint i = run.first; i < run.end; i += layered_none_seen(layered_bounds, i, whole) ? 16u : 1u) {
    const uint bounds = layered_bounds_of(layered_bounds, layered_extra_bounds, triangles, i);
    if (bounds != LAYERED_NO_BOUNDS) LAYERED_EACH_TILE(bounds, tile)++ counts[tile];
  }
}

// Exclusive sums over the chunks of each tile, and the tiles' totals; 16 tiles per work-item.
__kernel void layered_sum_bins(__global uint* layered_histogram, uint stride, __global uint* layered_starts) {
  const uint first = (uint)get_global_id(0) * 16u;
  if (first >= stride) return;
  uint16 sum = (uint16)(0u);
  for (uint chunk = 0u; chunk < LAYERED_CHUNKS; ++chunk) {
    __global uint* counts = layered_histogram + chunk * stride + first;
    const uint16 count = vload16(0, counts);
    vstore16(sum, 0, counts);
    sum += count;
  }
  vstore16(sum, 0, layered_starts + first);
}

// layered_pairs: records of tile t from layered_starts[t] on.
__kernel void layered_fill_bins(__global const uint* layered_bounds, __global const uint* layered_extra_bounds,
                                __global const uint* layered_clipped, uint triangles,
                                __global const LayeredView* layered_views, uint layered_view, uint stride,
                                __global uint* layered_histogram, __global const uint* layered_starts,
                                __global uint* layered_pairs) {
  const uint tiles_x = (layered_views[layered_view].width + LAYERED_LANES - 1u) / LAYERED_LANES;
  const uint chunk = get_global_id(0);
  __global uint* places = layered_histogram + chunk * stride;
  for (uint tile = 0u; tile < stride; tile += 16u)
    vstore16(vload16(0, places + tile) + vload16(0, layered_starts + tile), 0, places + tile);
  const LayeredRun run = layered_run(chunk, triangles + layered_clipped[0] * LAYERED_CLIP_PARTS);
  const uint whole = min(run.end, triangles);
  for (uint i = run.first; i < run.end; i += layered_none_seen(layered_bounds, i, whole) ? 16u : 1u) {
    const uint bounds = layered_bounds_of(layered_bounds, layered_extra_bounds, triangles, i);
    if (bounds != LAYERED_NO_BOUNDS) LAYERED_EACH_TILE(bounds, tile) layered_pairs[places[tile]++] = i;
  }
}
