// SPDX-License-Identifier: Apache-2.0
// In which cells of voxels the state of points changes, for parity: at fragments, and at the walls between neighbouring
// columns whose surfaces lie at different depths. Rays look at columns nowhere else.
#include "voxel_abuffer/structure/cell_marks.clh"

// What a work-item marks in.
typedef struct AbufferWallMarks {
  ulong* slabs;           // of the voxel column
  const ulong* searched;  // a bit for each of its voxels that are searched along its axis, or along any
  __global const float* depths;
  __global const uint* fragments;
  float per_pixel;  // cells per pixel
  uint last_slab;
} AbufferWallMarks;

// Whether a voxel's word says that it is searched along `axis`, or along any.
static bool abuffer_searched_along(uint word, uint axis) {
  const uint chosen = word >> ABUFFER_AXIS_SHIFT & 3u;
  return (word & ABUFFER_PARITY) && (chosen == axis || chosen == 3u);
}

// Finds those along a voxel column; whether there are any.
static bool abuffer_find_searched(const AbufferGrid* grid, __global const uint* voxels, uint axis, uint voxel_x,
                                  uint voxel_y, uint depth, ulong* searched) {
  ulong any = 0ul;
  for (uint z = 0u; z < depth; z += 64u) {
    ulong bits = 0ul;
    for (uint i = 0u; i < min(depth - z, 64u); ++i) {
      const uint index = abuffer_voxel(grid->bricks, abuffer_voxel_of(axis, voxel_x, voxel_y, z + i));
      bits |= (ulong)abuffer_searched_along(voxels[index], axis) << i;
    }
    searched[z >> 6] = bits;
    any |= bits;
  }
  return any != 0ul;
}

// Gives the voxels along a column their marks, in the slices across its axis only: abuffer_turn_cells() makes the
// others.
static void abuffer_give_walls(const AbufferWallMarks* m, const AbufferGrid* grid, __global const uint* voxels,
                               uint axis, uint voxel_x, uint voxel_y, uint depth, __global ulong* cells) {
  for (uint z = 0u; z < depth; ++z) {
    if (!(m->searched[z >> 6] >> (z & 63u) & 1ul)) continue;
    const uint word = voxels[abuffer_voxel(grid->bricks, abuffer_voxel_of(axis, voxel_x, voxel_y, z))];
    const uint block = (word >> ABUFFER_CELLS_SHIFT) + popcount(word & ABUFFER_EXACT_AXES);
    vstore8(abuffer_take_slabs(m->slabs, z), axis, cells + block * ABUFFER_CELL_WORDS);
  }
}

// Marks a column's cells from slab `first` to slab `last`, in the voxels that are searched: a wall may reach through
// the whole grid, past voxels of which few are.
static void abuffer_mark_slabs(const AbufferWallMarks* m, ulong section, uint first, uint last) {
  for (uint word = first >> 9; word <= last >> 9; ++word) {
    ulong voxels = m->searched[word];
    if (word == first >> 9) voxels &= ~0ul << (first >> 3 & 63u);
    if (word == last >> 9) voxels &= ~0ul >> (63u - (last >> 3 & 63u));
    for (; voxels; voxels &= voxels - 1ul) {
      const uint begin = 512u * word + 8u * (uint)popcount(~voxels & (voxels - 1ul));
      const uint end = min(last, begin + 7u);
      for (uint slab = max(first, begin); slab <= end; ++slab) m->slabs[slab] |= section;
    }
  }
}

static void abuffer_mark_depths(const AbufferWallMarks* m, ulong section, float low, float high) {
  const uint first = min((uint)(fmax(low, 0.0f) * m->per_pixel), m->last_slab);
  const uint last = min((uint)(fmax(high, 0.0f) * m->per_pixel), m->last_slab);
  abuffer_mark_slabs(m, section, first, last);
}

// What a fragment adds to the state (ABUFFER_OPEN_STEP).
static int abuffer_state_step(uint fragment) {
  const int step = fragment & ABUFFER_OPEN_FRAGMENT ? ABUFFER_OPEN_STEP : 1;
  return fragment >> 31 ? -step : step;
}

// Marks where the states of two columns differ. Lists: first fragment and end.
static void abuffer_mark_between(const AbufferWallMarks* m, ulong section, uint2 own, uint2 other) {
  int difference = 0;
  float since = 0.0f;
  while (own.x < own.y || other.x < other.y) {
    const float mine = own.x < own.y ? m->depths[own.x] : INFINITY;
    const float theirs = other.x < other.y ? m->depths[other.x] : INFINITY;
    if (difference) abuffer_mark_depths(m, section, since, fmin(mine, theirs));
    since = fmin(mine, theirs);
    if (mine <= theirs)
      difference += abuffer_state_step(m->fragments[own.x++]);
    else
      difference -= abuffer_state_step(m->fragments[other.x++]);
  }
}

// The list of a column.
typedef struct AbufferShortList {
  float8 depth;  // of its first eight fragments
  uint2 range;   // the first fragment and the end
  ulong faces;   // a byte for each of these: 1 against the axis, 255 along it, 3 and 253 of open components, 0 none
} AbufferShortList;

#define ABUFFER_LONG_LIST 0x0202020202020202ul  // its faces, if it has more than eight

static AbufferShortList abuffer_short_list(const AbufferWallMarks* m, __global const uint* start) {
  AbufferShortList list;
  list.range = vload2(0, start);
  list.depth = vload8(0, m->depths + list.range.x);
  const uint count = list.range.y - list.range.x;
  const int8 fragments = as_int8(vload8(0, m->fragments + list.range.x));
  const int8 open = (fragments & (int)ABUFFER_OPEN_FRAGMENT) != 0;
  const int8 facing = (fragments >> 31 ^ (open & 2)) | 1;
  const int8 lanes = (int8)(0, 1, 2, 3, 4, 5, 6, 7) < (int)count;
  list.faces = count > 8u ? ABUFFER_LONG_LIST : as_ulong(convert_char8(facing & lanes));
  return list;
}

// The lists of a line of columns in a voxel; for an empty line no fragments are read.
static void abuffer_short_lists(const AbufferWallMarks* m, __global const uint* start, uint line,
                                AbufferShortList* lists) {
  const bool empty = start[0] == start[line];
  for (uint x = 0u; x < line; ++x) {
    if (empty) {
      lists[x].depth = (float8)(0.0f);
      lists[x].range = (uint2)(start[0]);
      lists[x].faces = 0ul;
    } else {
      lists[x] = abuffer_short_list(m, start + x);
    }
  }
}

// Slabs that wait for their marks: those of consecutive columns are often the same.
typedef struct AbufferWaitingMarks {
  int8 first, last;
  uint count;
  ulong section;
} AbufferWaitingMarks;

static void abuffer_flush(const AbufferWallMarks* m, AbufferWaitingMarks* waiting) {
  uint firsts[8], lasts[8];
  vstore8(as_uint8(waiting->first), 0, firsts);
  vstore8(as_uint8(waiting->last), 0, lasts);
  for (uint i = 0u; i < waiting->count; ++i) abuffer_mark_slabs(m, waiting->section, firsts[i], lasts[i]);
  waiting->count = 0u;
  waiting->section = 0ul;
}

static int8 abuffer_slabs(const AbufferWallMarks* m, float8 depth) {
  const float8 slab = depth * m->per_pixel, last = (float8)((float)m->last_slab);
  return convert_int8(slab > 0.0f ? (slab < last ? slab : last) : (float8)(0.0f));
}

// A column's neighbours, left, right, below and above it, in pairs with it.
typedef struct AbufferNeighbours {
  const AbufferShortList* list[4];
  ulong section[4];  // where a pair's walls are marked; 0: the neighbour has marked them
} AbufferNeighbours;

// Marks a column's fragments, and its walls to four neighbours. Where a neighbour has as many fragments, facing alike,
// its walls reach as far as these are apart.
static void abuffer_mark_column(const AbufferWallMarks* m, AbufferWaitingMarks* waiting, const AbufferShortList* own,
                                const AbufferNeighbours* neighbours, ulong section) {
  const uint count = own->range.y - own->range.x;
  float8 low = own->depth, high = own->depth;
  for (uint k = 0u; k < 4u; ++k) {
    const AbufferShortList* other = neighbours->list[k];
    if (own->faces == other->faces && count <= 8u) {
      low = other->depth < low ? other->depth : low;
      high = other->depth > high ? other->depth : high;
    } else if (neighbours->section[k]) {
      abuffer_mark_between(m, neighbours->section[k], own->range, other->range);
    }
  }
  if (count > 8u) {
    for (uint i = own->range.x; i < own->range.y; ++i) abuffer_mark_depths(m, section, m->depths[i], m->depths[i]);
  } else if (count > 0u) {
    const int8 first = abuffer_slabs(m, low), last = abuffer_slabs(m, high);
    const int8 lanes = (int8)(0, 1, 2, 3, 4, 5, 6, 7) < (int)count;
    const int8 differ = ((first ^ waiting->first) | (last ^ waiting->last)) & lanes;
    if (waiting->count != count || as_ulong(convert_char8(differ != 0)) != 0ul) {
      abuffer_flush(m, waiting);
      waiting->first = first;
      waiting->last = last;
      waiting->count = count;
    }
    waiting->section |= section;
  }
}

// One row of voxel columns per work-item: no two write to one voxel.
__kernel void abuffer_mark_walls_of_row(__global const AbufferGrid* abuffer_grid, __global const uint* abuffer_start,
                                        __global const float* abuffer_depths, __global const uint* abuffer_fragments,
                                        __global const uint* abuffer_counts, uint axis, uint first, uint capacity,
                                        __global const uint* abuffer_voxels, uint cell_capacity,
                                        __global ulong* abuffer_cells, DEALT_ROW_PARAMETER) {
  const AbufferGrid grid = abuffer_grid[0];
  const uint edge = grid.voxels.w, columns = abuffer_component(grid.voxels, abuffer_axis_x(axis));
  const uint rows = abuffer_component(grid.voxels, abuffer_axis_y(axis)), row = DEALT_ROW;
  const uint depth = abuffer_component(grid.voxels, axis);
  const int line = (int)edge, size = line * line, row_size = (int)columns * size;
  if (row >= rows) return;
  if (abuffer_counts[first + axis + 1u] > capacity || abuffer_counts[ABUFFER_COUNT_CELLS] > cell_capacity) return;
  AbufferSections sections;
  abuffer_find_sections(edge, &sections);
  AbufferShortList lines[3][ABUFFER_GRID_VOXEL_EDGE];
  ulong slabs[ABUFFER_SLABS], searched[(ABUFFER_GRID_VOXELS + 63) / 64];
  abuffer_clear_slabs(slabs, depth);
  AbufferWallMarks m = {slabs, searched, abuffer_depths, abuffer_fragments, 8.0f / (float)edge, 8u * depth - 1u};
  AbufferWaitingMarks waiting = {(int8)(0), (int8)(0), 0u, 0ul};
  __global const uint* start = abuffer_start + axis * grid.bricks.w + (int)row * row_size;
  for (uint voxel = 0u; voxel < columns; ++voxel, start += size) {
    if (!abuffer_find_searched(&grid, abuffer_voxels, axis, voxel, row, depth, searched)) continue;
    // Go from column to column, with the lists of three lines of them. Neighbours may be in the next voxel; beside the
    // grid there is nothing.
    AbufferShortList *below = lines[0], *here = lines[1], *above = lines[2];
    abuffer_short_lists(&m, row > 0u ? start + size - row_size - line : start, edge, below);
    abuffer_short_lists(&m, start, edge, here);
    for (int y = 0; y < line; ++y) {
      const int begin = y * line, end = begin + line;
      const bool last = y + 1 == line;
      abuffer_short_lists(&m, start + (!last ? end : row + 1u < rows ? row_size : begin), edge, above);
      const AbufferShortList left = voxel > 0u ? abuffer_short_list(&m, start + end - size - 1) : here[0];
      const AbufferShortList right =
          voxel + 1u < columns ? abuffer_short_list(&m, start + begin + size) : here[line - 1];
      ulong section = abuffer_cell_section(&sections, 0u, (uint)y);
      for (int x = 0; x < line; ++x) {
        const ulong over = last ? 0ul : abuffer_cell_section(&sections, (uint)x, (uint)y + 1u);
        const ulong beside = x + 1 < line ? abuffer_cell_section(&sections, (uint)x + 1u, (uint)y) : 0ul;
        // Walls within the voxel column are marked for both sides at once.
        const AbufferNeighbours neighbours = {
            {x > 0 ? &here[x - 1] : &left, x + 1 < line ? &here[x + 1] : &right, &below[x], &above[x]},
            {x > 0 ? 0ul : section, section | beside, y > 0 ? 0ul : section, section | over}};
        abuffer_mark_column(&m, &waiting, &here[x], &neighbours, section);
        section = beside;
      }
      abuffer_flush(&m, &waiting);
      AbufferShortList* const free = below;
      below = here;
      here = above;
      above = free;
    }
    abuffer_give_walls(&m, &grid, abuffer_voxels, axis, voxel, row, depth, abuffer_cells);
  }
}
