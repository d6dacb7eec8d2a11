// SPDX-License-Identifier: Apache-2.0
// Which tiles of subfields each facet needs: rectangles about its projections, then the tiles in them that it meets,
// with a margin of one cell for interpolation (Mortensen et al. 2007, section 3.1: tiles cover only the face).
#include "lucarium/shared/scene_types.h"
#include "virtual_light_field/shared/field.h"
#include "virtual_light_field/tiles/subfield_cells.clh"

#define FACET_PARAMETERS                                                                                             \
  const __global Vertex *restrict scene_vertices, const __global Triangle *restrict scene_triangles, FieldInfo info, \
      const __global FieldLine *restrict lines, const __global FieldFacet *restrict facets,                          \
      const __global uint *restrict facet_triangles

// A triangle of a facet on a subfield [cells].
typedef struct Projected {
  float2 p[3];
  float2 low, high;
  bool faces;  // the facet's side of it is seen from the direction
} Projected;

Projected project_triangle(const __global Vertex* vertices, Triangle triangle, FieldLine line, bool front,
                           bool backwards) {
  Projected result;
  const float3 a = vertices[triangle.v0].position.xyz, b = vertices[triangle.v1].position.xyz,
               c = vertices[triangle.v2].position.xyz;
  const float along = dot(cross(b - a, c - a), line.omega.xyz);
  result.faces = (along > 0.0f) == (front != backwards) && along != 0.0f;
  result.p[0] = subfield_point(line, a);
  result.p[1] = subfield_point(line, b);
  result.p[2] = subfield_point(line, c);
  result.low = fmin(result.p[0], fmin(result.p[1], result.p[2])) - 1.0f;
  result.high = fmax(result.p[0], fmax(result.p[1], result.p[2])) + 1.0f;
  return result;
}

// First and last tile of a facet's triangle, clamped to the subfield.
int4 tile_range(Projected t, uint subfield, uint m) {
  const float last = (float)(subfield - 1u);
  const float2 low = clamp(t.low, 0.0f, last), high = clamp(t.high, 0.0f, last);
  return (int4)((int)low.x, (int)low.y, (int)high.x, (int)high.y) / (int)max(m, 1u);
}

// Work-item (facet, direction): the rectangle of tiles, and how many it has. line_levels: the greatest level whose grid
// has the line.
__kernel void bound_maps(FACET_PARAMETERS, const __global uint* restrict line_levels, __global FieldMap* restrict maps,
                         __global uint* restrict counts) {
  const uint facet = get_global_id(0), direction = get_global_id(1);
  if (facet >= info.facets) return;
  const FieldFacet own = facets[facet];
  const FieldLine line = lines[direction >> 1];
  int4 range = (int4)(INT_MAX, INT_MAX, -1, -1);
  const uint count = own.level <= line_levels[direction >> 1] ? own.count : 0u;
  for (uint i = own.first; i < own.first + count; ++i) {
    const Projected t =
        project_triangle(scene_vertices, scene_triangles[facet_triangles[i]], line, own.front, direction & 1u);
    if (!t.faces) continue;
    const int4 tiles = tile_range(t, info.subfield, own.tile);
    range = (int4)(min(range.xy, tiles.xy), max(range.zw, tiles.zw));
  }
  const bool seen = range.z >= 0, rows = own.tile == 0u;
  if (rows) range.x = range.z = 0;
  const uint w = seen ? (uint)(range.z - range.x + 1) : 0u, h = seen ? (uint)(range.w - range.y + 1) : 0u;
  const size_t index = (size_t)direction * info.facets + facet;
  FieldMap map;
  map.first = 0u;
  map.corner = seen ? (uint)range.x * own.tile | (uint)range.y * max(own.tile, 1u) << 16 : 0u;
  map.size = w | h << 12 | own.tile << 24 | own.level << 30;
  maps[index] = map;
  counts[index] = rows ? 2u * h : w * h;
}

// Whether a triangle comes near a square: not when it lies beyond one of the triangle's edges.
bool touches(Projected t, float2 low, float2 high) {
  if (any(t.high < low) || any(t.low > high)) return false;
  for (int k = 0; k < 3; ++k) {
    const float2 a = t.p[k], edge = t.p[(k + 1) % 3] - a, other = t.p[(k + 2) % 3] - a;
    float2 out = (float2)(edge.y, -edge.x);
    if (dot(out, other) > 0.0f) out = -out;
    // The square's corner that is deepest inside, with a margin of one cell.
    const float2 corner = (float2)(out.x > 0.0f ? low.x : high.x, out.y > 0.0f ? low.y : high.y);
    if (dot(out, corner - a) > length(out)) return false;
  }
  return true;
}

// Work-item (facet, direction): starts: where its entries begin. fine, coarse: cells of each entry, 0 where no triangle
// comes, of facets without a level and of those with one.
__kernel void mark_tiles(FACET_PARAMETERS, const __global uint* restrict starts, __global FieldMap* restrict maps,
                         __global uint* fine, __global uint* coarse) {
  const uint facet = get_global_id(0), direction = get_global_id(1);
  if (facet >= info.facets) return;
  const size_t index = (size_t)direction * info.facets + facet;
  FieldMap map = maps[index];
  map.first = starts[index];
  maps[index] = map;
  const FieldFacet own = facets[facet];
  const FieldLine line = lines[direction >> 1];
  const uint w = FIELD_MAP_WIDTH(map), h = FIELD_MAP_HEIGHT(map), m = own.tile;
  __global uint* cells = own.level > 0u ? coarse : fine;
  for (uint i = 0u; i < w * h; ++i) cells[map.first + i] = 0u;
  if (w == 0u) return;
  const int2 corner = (int2)((int)(map.corner & 0xffffu), (int)(map.corner >> 16)) / (int)m;
  for (uint i = own.first; i < own.first + own.count; ++i) {
    const Projected t =
        project_triangle(scene_vertices, scene_triangles[facet_triangles[i]], line, own.front, direction & 1u);
    if (!t.faces) continue;
    const int4 tiles = tile_range(t, info.subfield, m);
    for (int y = tiles.y; y <= tiles.w; ++y)
      for (int x = tiles.x; x <= tiles.z; ++x)
        if (touches(t, (float2)((float)x, (float)y) * (float)m, (float2)((float)(x + 1), (float)(y + 1)) * (float)m))
          cells[map.first + (uint)(y - corner.y) * w + (uint)(x - corner.x)] = m * m;
  }
}

// First and last cell of a triangle within a cell of the row y, clamped to the subfield; empty: last before first.
int2 row_range(Projected t, int y, uint subfield) {
  const float low = (float)(y - 1), high = (float)(y + 2);
  float first = INFINITY, last = -INFINITY;
  for (int k = 0; k < 3; ++k) {
    const float2 a = t.p[k], b = t.p[(k + 1) % 3];
    if (fmax(a.y, b.y) < low || fmin(a.y, b.y) > high) continue;
    const float slope = b.y != a.y ? (b.x - a.x) / (b.y - a.y) : 0.0f;
    const bool level = fabs(b.y - a.y) < 1e-3f;
    const float from = level ? a.x : a.x + slope * (clamp(a.y, low, high) - a.y);
    const float to = level ? b.x : a.x + slope * (clamp(b.y, low, high) - a.y);
    first = fmin(first, fmin(from, to));
    last = fmax(last, fmax(from, to));
  }
  if (first > last) return (int2)(0, -1);
  return (int2)((int)clamp(first - 1.0f, 0.0f, (float)(subfield - 1u)),
                (int)clamp(last + 1.0f, 0.0f, (float)(subfield - 1u)));
}

// The same with store=csr: cells of each row, at its even entry; spans: where it begins, x | cells << 16, at its odd
// one. Between its ends a row has no gaps, whether or not the facet has.
__kernel void mark_rows(FACET_PARAMETERS, const __global uint* restrict starts, __global FieldMap* restrict maps,
                        __global uint* fine, __global uint* coarse, __global uint* restrict spans) {
  const uint facet = get_global_id(0), direction = get_global_id(1);
  if (facet >= info.facets) return;
  const size_t index = (size_t)direction * info.facets + facet;
  FieldMap map = maps[index];
  map.first = starts[index];
  maps[index] = map;
  const FieldFacet own = facets[facet];
  const FieldLine line = lines[direction >> 1];
  const int y0 = (int)(map.corner >> 16);
  const uint h = FIELD_MAP_HEIGHT(map);
  __global uint* cells = own.level > 0u ? coarse : fine;
  for (uint i = 0u; i < 2u * h; ++i) cells[map.first + i] = spans[map.first + i] = 0u;
  if (h == 0u) return;
  for (uint i = own.first; i < own.first + own.count; ++i) {
    const Projected t =
        project_triangle(scene_vertices, scene_triangles[facet_triangles[i]], line, own.front, direction & 1u);
    if (!t.faces) continue;
    const int4 range = tile_range(t, info.subfield, 1u);
    for (int y = range.y; y <= range.w; ++y) {
      int2 row = row_range(t, y, info.subfield);
      if (row.y < row.x) continue;
      const uint entry = map.first + 2u * (uint)(y - y0), count = cells[entry], begin = spans[entry + 1u] & 0xffffu;
      if (count) row = (int2)(min(row.x, (int)begin), max(row.y, (int)(begin + count) - 1));
      cells[entry] = (uint)(row.y - row.x + 1);
      spans[entry + 1u] = (uint)row.x | cells[entry] << 16;
    }
  }
}

// Work-item: an entry. rows: 1 with store=csr; spans: see mark_rows(). offsets: cells before it, of their kind; coarse
// ones follow fine_cells others. tile_cells: its first cell, and flags for a list of tiles.
__kernel void number_tiles(uint count, uint rows, uint fine_cells, const __global uint* restrict spans,
                           const __global uint* restrict fine, const __global uint* restrict coarse,
                           const __global uint* restrict fine_offsets, const __global uint* restrict coarse_offsets,
                           __global uint* restrict tile_cells, __global uint* restrict flags) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const uint first = fine[i] ? fine_offsets[i] : coarse[i] ? fine_cells + coarse_offsets[i] : LUCARIUM_NONE;
  tile_cells[i] = rows && i & 1u ? spans[i] : first;
  flags[i] = first != LUCARIUM_NONE;
}

// Work-item: a direction. Its first cell; `total` behind the last. before: cells of the other kind that come first.
__kernel void begin_directions(uint facets, uint directions, uint entries, uint before, uint total,
                               const __global FieldMap* restrict maps, const __global uint* restrict offsets,
                               __global uint* restrict first_cells) {
  const uint direction = get_global_id(0);
  if (direction > directions) return;
  const uint entry = direction < directions ? maps[(size_t)direction * facets].first : entries;
  first_cells[direction] = before + (entry < entries ? offsets[entry] : total);
}
