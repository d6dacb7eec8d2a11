// SPDX-License-Identifier: Apache-2.0
// The textbook ways to a stored A-buffer, for comparison: one work-item per triangle and atomics per fragment, either
// into places counted before (count, scan, fill) or onto a linked list per pixel (Yang et al. 2010), sorted afterwards.
#ifndef LAYERED_DEPTH
#define LAYERED_DEPTH
#endif
#include "lucarium/shared/layered_raster.h"

// Where fragments go.
typedef struct LayeredLists {
  uint mode;  // LAYERED_MODE_*
  uint width, capacity;
  volatile __global uint* counts;       // per pixel: fragments (COUNT), next place (FILL), newest node + 1 (LINK)
  volatile __global uint* node_count;   // LINK
  __global LayeredFragment* fragments;  // FILL: places; LINK: nodes
  __global uint* next;                  // LINK: the node before + 1, 0: none
} LayeredLists;
#define LAYERED_CONSUMER LayeredLists
#define LAYERED_PAYLOAD uint
#include "lucarium/services/layered_raster/sort_list.clh"
#include "lucarium/services/layered_raster/tiles.clh"

uint layered_payload(LayeredLists* lists, uint triangle, const LayeredPlanes* planes) { return triangle; }
LayeredUint layered_payload_row(const uint* triangle, float row, LayeredFloat w) { return (LayeredUint)(*triangle); }
void layered_prepare(LayeredLists* lists, LayeredRow* row) {}
void layered_consume(LayeredLists* lists, const LayeredRow* row) {}

static void layered_emit(LayeredLists* lists, uint pixel, uint triangle, float depth) {
  const LayeredFragment fragment = {triangle, depth};
  if (lists->mode == LAYERED_MODE_COUNT) {
    atomic_inc(lists->counts + pixel);
  } else if (lists->mode == LAYERED_MODE_FILL) {
    lists->fragments[atomic_inc(lists->counts + pixel)] = fragment;
  } else {
    const uint node = atomic_inc(lists->node_count);
    if (node >= lists->capacity) return;
    lists->fragments[node] = fragment;
    lists->next[node] = atomic_xchg(lists->counts + pixel, node + 1u);
  }
}

// Tile by tile, so that depths are the same bits as those of the tiles variant.
static void layered_emit_triangle(const LayeredTiles* tiles, LayeredLists* lists, uint index) {
  const LayeredRecord r = layered_record(tiles, index);
  for (uint py = (r.y.w & 0xffff) / LAYERED_TILE_ROWS * LAYERED_TILE_ROWS; py <= (uint)r.y.w >> 16;
       py += LAYERED_TILE_ROWS)
    for (uint px = (r.x.w & 0xffff) / LAYERED_LANES * LAYERED_LANES; px <= (uint)r.x.w >> 16; px += LAYERED_LANES) {
      LayeredWalk walk = layered_walk(tiles, &r, (int)px, (int)py);
      for (uint row = walk.first; row <= walk.last; ++row) {
        uint mask = ~layered_signs(walk.e0 | walk.e1 | walk.e2 | walk.outside) & LAYERED_ALL_LANES;
        walk.e0 += walk.step_y.x;
        walk.e1 += walk.step_y.y;
        walk.e2 += walk.step_y.z;
        if (!mask) continue;
        LayeredFloat w;
        const LayeredFloat depth = layered_row_depth(&walk, (float)row, &w);
#ifdef LAYERED_ALPHA
        if (r.flags & LAYERED_RECORD_ALPHA)
          mask = layered_alpha(tiles, &walk, r.triangle & ~LAYERED_AWAY, mask, (float)row, w, px, py + row);
#endif
        for (; mask; mask &= mask - 1u) {
          const uint lane = layered_first(mask);
          layered_emit(lists, (py + row) * lists->width + px + lane, r.triangle, ((const float*)&depth)[lane]);
        }
      }
    }
}

// capacity_counter: nothing is done when it is 0.
__kernel void layered_list_fragments(LAYERED_TILE_PARAMETERS __global const uint* layered_bounds,
                                     __global const uint* layered_extra_bounds, __global const uint* layered_clipped,
                                     uint mode, __global const uint* capacity_counter, __global uint* counts,
                                     __global uint* node_count, __global LayeredFragment* fragments,
                                     __global uint* next) {
  LayeredTiles tiles;
  LAYERED_SET_TILES(tiles);
  LayeredLists lists = {mode, tiles.view->width, capacity_counter[0], counts, node_count, fragments, next};
  if (lists.capacity == 0u) return;
  const uint first = (uint)get_global_id(0) * 64u, total = layered_triangles + layered_clipped[0] * LAYERED_CLIP_PARTS;
  for (uint i = first; i < min(first + 64u, layered_triangles); ++i)
    if (layered_bounds[i] != LAYERED_NO_BOUNDS) layered_emit_triangle(&tiles, &lists, i);
  // Parts of clipped triangles are shared out among all work-items.
  for (uint i = layered_triangles + (uint)get_global_id(0); i < total; i += (uint)get_global_size(0))
    if (layered_extra_bounds[i - layered_triangles] != LAYERED_NO_BOUNDS) layered_emit_triangle(&tiles, &lists, i);
}

// Nodes that a second try needs: all when they did not fit, else 0.
__kernel void layered_list_shortage(__global const uint* node_count, uint capacity, __global uint* needed) {
  needed[0] = node_count[0] > capacity ? node_count[0] : 0u;
}

__kernel void layered_copy_starts(__global const uint* pixel_start, __global uint* places, uint pixels) {
  const uint i = get_global_id(0);
  if (i < pixels) places[i] = pixel_start[i];
}

// Length of every list; the entry behind the last pixel becomes 0.
__kernel void layered_list_lengths(__global const uint* heads, __global const uint* next, __global const uint* needed,
                                   __global const uint* more_heads, __global const uint* more_next, uint pixels,
                                   __global uint* pixel_counts) {
  const uint i = get_global_id(0);
  if (i > pixels) return;
  __global const uint* first = needed[0] ? more_heads : heads;
  __global const uint* links = needed[0] ? more_next : next;
  uint count = 0u;
  if (i < pixels)
    for (uint node = first[i]; node; node = links[node - 1u]) ++count;
  pixel_counts[i] = count;
}

__kernel void layered_list_collect(__global const uint* heads, __global const uint* next,
                                   __global const LayeredFragment* nodes, __global const uint* needed,
                                   __global const uint* more_heads, __global const uint* more_next,
                                   __global const LayeredFragment* more_nodes, uint pixels,
                                   __global const uint* pixel_start, __global LayeredFragment* fragments) {
  const uint i = get_global_id(0);
  if (i >= pixels) return;
  __global const LayeredFragment* from = needed[0] ? more_nodes : nodes;
  __global const uint* links = needed[0] ? more_next : next;
  uint place = pixel_start[i];
  for (uint node = (needed[0] ? more_heads : heads)[i]; node; node = links[node - 1u])
    fragments[place++] = from[node - 1u];
}

__kernel void layered_sort_pixels(__global const LayeredView* layered_views, uint layered_view, uint pixels,
                                  __global const uint* pixel_start, __global LayeredFragment* fragments) {
  const uint i = get_global_id(0);
  if (i >= pixels) return;
  const LayeredView view = layered_views[layered_view];
  layered_sort_list(&view, fragments + pixel_start[i], pixel_start[i + 1u] - pixel_start[i]);
}
