// SPDX-License-Identifier: Apache-2.0
// In which cells of voxels the state of points changes, for parity: at fragments, and at the walls between neighbouring
// columns whose surfaces lie at different depths. Rays look at columns nowhere else.
#include "voxel_abuffer/structure/cell_marks.clh"

// What a work-item marks in.
typedef struct AbufferWallMarks {
  __global ulong* cells;
  __global const float* depths;
  __global const uint* fragments;
  const uint* places;
  ulong section;    // of the column
  float per_pixel;  // cells per pixel
  uint last_slab;
} AbufferWallMarks;

// Where the cells begin of the voxels along a voxel column that are searched along `axis`, or along any; whether there
// are any.
static bool abuffer_searched_cells(const AbufferGrid* grid, __global const uint* voxels, uint axis, uint voxel_x,
                                   uint voxel_y, uint depth, uint* places) {
  bool any = false;
  for (uint z = 0u; z < depth; ++z) {
    const uint word = voxels[abuffer_voxel(grid->bricks, abuffer_voxel_of(axis, voxel_x, voxel_y, z))];
    const uint chosen = word >> ABUFFER_AXIS_SHIFT & 3u;
    const uint block = (word >> ABUFFER_CELLS_SHIFT) + popcount(word & ABUFFER_EXACT_AXES);
    const bool here = (word & ABUFFER_PARITY) && (chosen == axis || chosen == 3u);
    places[z] = here ? block * ABUFFER_CELL_WORDS + 8u * axis : ABUFFER_NO_CELLS;
    any |= here;
  }
  return any;
}

static void abuffer_mark_depths(const AbufferWallMarks* m, float low, float high) {
  const uint first = min((uint)(fmax(low, 0.0f) * m->per_pixel), m->last_slab);
  const uint last = min((uint)(fmax(high, 0.0f) * m->per_pixel), m->last_slab);
  abuffer_mark_slabs(m->cells, m->places, m->section, first, last);
}

// What a fragment adds to the state (ABUFFER_OPEN_STEP).
static int abuffer_state_step(uint fragment) {
  const int step = fragment & ABUFFER_OPEN_FRAGMENT ? ABUFFER_OPEN_STEP : 1;
  return fragment >> 31 ? -step : step;
}

// Marks where the states of two columns differ. Lists: first fragment and end.
static void abuffer_mark_between(const AbufferWallMarks* m, uint2 own, uint2 other) {
  int difference = 0;
  float since = 0.0f;
  while (own.x < own.y || other.x < other.y) {
    const float mine = own.x < own.y ? m->depths[own.x] : INFINITY;
    const float theirs = other.x < other.y ? m->depths[other.x] : INFINITY;
    if (difference) abuffer_mark_depths(m, since, fmin(mine, theirs));
    since = fmin(mine, theirs);
    if (mine <= theirs)
      difference += abuffer_state_step(m->fragments[own.x++]);
    else
      difference -= abuffer_state_step(m->fragments[other.x++]);
  }
}

// The list of a column.
typedef struct AbufferShortList {
  uint2 range;   // its first fragment and its end
  float8 depth;  // of its first eight
  ulong faces;   // a byte for each of these: 1 against the axis, 255 along it, 3 and 253 of open components, 0 none
} AbufferShortList;

static AbufferShortList abuffer_short_list(const AbufferWallMarks* m, __global const uint* start) {
  AbufferShortList list;
  list.range = vload2(0, start);
  list.depth = vload8(0, m->depths + list.range.x);
  const int8 fragments = as_int8(vload8(0, m->fragments + list.range.x));
  const int8 open = (fragments & (int)ABUFFER_OPEN_FRAGMENT) != 0;
  const int8 facing = (fragments >> 31 ^ (open & 2)) | 1;
  const int8 lanes = (int8)(0, 1, 2, 3, 4, 5, 6, 7) < (int)(list.range.y - list.range.x);
  list.faces = as_ulong(convert_char8(facing & lanes));
  return list;
}

// Slabs that wait for their marks: those of consecutive columns are often the same.
typedef struct AbufferWaitingMarks {
  int8 first, last;
  uint count;
} AbufferWaitingMarks;

static void abuffer_flush(AbufferWallMarks* m, AbufferWaitingMarks* waiting) {
  uint firsts[8], lasts[8];
  vstore8(as_uint8(waiting->first), 0, firsts);
  vstore8(as_uint8(waiting->last), 0, lasts);
  for (uint i = 0u; i < waiting->count; ++i) abuffer_mark_slabs(m->cells, m->places, m->section, firsts[i], lasts[i]);
  waiting->count = 0u;
  m->section = 0ul;
}

static int8 abuffer_slabs(const AbufferWallMarks* m, float8 depth) {
  const float8 slab = depth * m->per_pixel, last = (float8)((float)m->last_slab);
  return convert_int8(slab > 0.0f ? (slab < last ? slab : last) : (float8)(0.0f));
}

// Marks what cannot wait: a long list, or walls to neighbours that do not have as many fragments, facing alike.
static void abuffer_mark_unlike(AbufferWallMarks* m, AbufferWaitingMarks* waiting, const AbufferShortList* own,
                                const AbufferShortList* const* others, ulong section) {
  abuffer_flush(m, waiting);
  m->section = section;
  for (uint i = own->range.x; i < own->range.y; ++i) abuffer_mark_depths(m, m->depths[i], m->depths[i]);
  for (uint k = 0u; k < 4u; ++k) abuffer_mark_between(m, own->range, others[k]->range);
  m->section = 0ul;
}

// Marks a column's fragments, and its walls to four neighbours: where all have as many fragments, facing alike, each
// one's walls reach as far as theirs.
static void abuffer_mark_column(AbufferWallMarks* m, AbufferWaitingMarks* waiting, const AbufferShortList* own,
                                const AbufferShortList* const* others, ulong section) {
  const uint count = own->range.y - own->range.x;
  const ulong unlike = (own->faces ^ others[0]->faces) | (own->faces ^ others[1]->faces) |
                       (own->faces ^ others[2]->faces) | (own->faces ^ others[3]->faces);
  uint longest = count;
  for (uint k = 0u; k < 4u; ++k) longest = max(longest, others[k]->range.y - others[k]->range.x);
  if (longest == 0u) return;
  if (unlike || longest > 8u) {
    abuffer_mark_unlike(m, waiting, own, others, section);
    return;
  }
  float8 low = own->depth, high = own->depth;
  for (uint k = 0u; k < 4u; ++k) {
    const float8 theirs = others[k]->depth;
    low = theirs < low ? theirs : low;
    high = theirs > high ? theirs : high;
  }
  const int8 first = abuffer_slabs(m, low), last = abuffer_slabs(m, high);
  const int8 lanes = (int8)(0, 1, 2, 3, 4, 5, 6, 7) < (int)count;
  const int8 differ = ((first ^ waiting->first) | (last ^ waiting->last)) & lanes;
  if (waiting->count != count || as_ulong(convert_char8(differ != 0)) != 0ul) {
    abuffer_flush(m, waiting);
    waiting->first = first;
    waiting->last = last;
    waiting->count = count;
  }
  m->section |= section;
}

// One row of voxel columns per work-item: no two write to one voxel.
__kernel void abuffer_mark_walls_of_row(__global const AbufferGrid* abuffer_grid, __global const uint* abuffer_start,
                                        __global const float* abuffer_depths, __global const uint* abuffer_fragments,
                                        __global const uint* abuffer_counts, uint axis, uint first, uint capacity,
                                        __global const uint* abuffer_voxels, uint cell_capacity,
                                        __global ulong* abuffer_cells) {
  const AbufferGrid grid = abuffer_grid[0];
  const uint edge = grid.voxels.w, columns = abuffer_component(grid.voxels, abuffer_axis_x(axis));
  const uint rows = abuffer_component(grid.voxels, abuffer_axis_y(axis)), row = get_global_id(0);
  const uint depth = abuffer_component(grid.voxels, axis);
  const int line = (int)edge, size = line * line, row_size = (int)columns * size;
  if (row >= rows) return;
  if (abuffer_counts[first + axis + 1u] > capacity || abuffer_counts[ABUFFER_COUNT_CELLS] > cell_capacity) return;
  uint places[ABUFFER_MAX_VOXELS];
  AbufferWallMarks m = {abuffer_cells, abuffer_depths,     abuffer_fragments, places,
                        0ul,           8.0f / (float)edge, 8u * depth - 1u};
  AbufferWaitingMarks waiting = {(int8)(0), (int8)(0), 0u};
  __global const uint* start = abuffer_start + axis * grid.bricks.w + (int)row * row_size;
  for (uint voxel = 0u; voxel < columns; ++voxel, start += size) {
    if (!abuffer_searched_cells(&grid, abuffer_voxels, axis, voxel, row, depth, places)) continue;
    // Go from column to column. Neighbours may be in the next voxel; beside the grid there is nothing.
    AbufferCellSpan y_cells = abuffer_first_span(edge);
    for (int y = 0; y < line; ++y, abuffer_next_span(&y_cells, edge)) {
      const int begin = y * line;
      const int below = y > 0 ? -line : row > 0u ? size - row_size - line : 0;
      const int above = y + 1 < line ? line : row + 1u < rows ? row_size - size + line : 0;
      AbufferShortList own = abuffer_short_list(&m, start + begin);
      AbufferShortList left = voxel > 0u ? abuffer_short_list(&m, start + begin - size + line - 1) : own;
      AbufferCellSpan x_cells = abuffer_first_span(edge);
      for (int x = 0; x < line; ++x, abuffer_next_span(&x_cells, edge)) {
        const int here = begin + x;
        const int next = x + 1 < line ? here + 1 : voxel + 1u < columns ? here + size - line + 1 : here;
        const AbufferShortList right = abuffer_short_list(&m, start + next);
        const AbufferShortList down = abuffer_short_list(&m, start + here + below);
        const AbufferShortList up = abuffer_short_list(&m, start + here + above);
        const AbufferShortList* const others[4] = {&left, &right, &down, &up};
        abuffer_mark_column(&m, &waiting, &own, others, abuffer_cell_section(x_cells, y_cells));
        left = own;
        own = right;
      }
      abuffer_flush(&m, &waiting);
    }
  }
}
