// SPDX-License-Identifier: Apache-2.0
// The light field as host and kernels see it: lines, their subfields, and where the tiles of facets lie on them.
//
// Direction 2 l is omega of line l, direction 2 l + 1 is -omega; both share one subfield of N x N cells. A facet is one
// side of a patch; a map holds the cells of one facet on the subfield of one direction, in tiles of m x m cells. Its
// radiance `in` comes from the direction, `out` and its totals leave towards it.
#ifndef VIRTUAL_LIGHT_FIELD_SHARED_FIELD_H
#define VIRTUAL_LIGHT_FIELD_SHARED_FIELD_H
#include "lucarium/shared/dialect.h"

LUCARIUM_STRUCT_BEGIN(FieldLine)
float4 omega;  // xyz unit; w: solid angle of each of its two directions [sr]
float4 row_x;  // subfield coordinates [cells]: row · (p, 1)
float4 row_y;
float4 row_w;  // depth along omega [m]
LUCARIUM_STRUCT_END(FieldLine, 64)

// Where the tiles of a map are: entries first + y w + x of tile_cells are the first cells of tiles, LUCARIUM_NONE where
// there is none.
// With store=csr a map is rows of cells instead: m is 0, w is 1, h the number of rows; entries first + 2 y are the
// first cells of rows, LUCARIUM_NONE where there is none, first + 2 y + 1 where a row begins, x | cells << 16.
LUCARIUM_STRUCT_BEGIN(FieldMap)
uint first;
uint corner;  // first cell x | y << 16 of the rectangle, multiples of m; of rows x is 0
uint size;    // in tiles: w | h << 12; m << 24; level of the facet << 30, in all of its maps
LUCARIUM_STRUCT_END(FieldMap, 12)
#define FIELD_MAP_WIDTH(map) ((map).size & 0xfffu)
#define FIELD_MAP_HEIGHT(map) ((map).size >> 12 & 0xfffu)
#define FIELD_MAP_TILE(map) ((map).size >> 24 & 63u)
#define FIELD_MAP_LEVEL(map) ((map).size >> 30)

LUCARIUM_STRUCT_BEGIN(FieldInfo)
float4 rotation0, rotation1, rotation2;  // rows: world to the axes of the octahedral grid
uint grid;                               // n: cells of the grid per edge of the octahedron
uint lines;                              // 2 n^2 + 1
uint facets;
uint subfield;      // N: cells per edge of a subfield
float cell;         // c: edge of a cell [m]
float texel_edge;   // of the surface atlas [m]
float angle;        // spacing of directions delta [rad]
uint first_coarse;  // cell; from here on those of facets with a level
LUCARIUM_STRUCT_END(FieldInfo, 80)

// What stands for a cell without light in RGB9E5; pack_cell() never makes it.
#define FIELD_NO_CELL 0xffffffffu

// Of a facet: its triangles are [first, first + count) of a list; which side of them it is, its tile m.
LUCARIUM_STRUCT_BEGIN(FieldFacet)
uint first, count;
uint front;  // 1: fronts of triangles, 0: backs
uint tile;   // 0: rows
uint level;  // it has maps for the directions of the grid n / 2^level alone (dir_levels)
LUCARIUM_STRUCT_END(FieldFacet, 20)

#define CELL_REACH 2.0f  // farthest point of a cell from that of its texel side [texel edges]

// What rays of other directions than a cell's own bring to it: four sums (radiance times scale, rays) of 64 bits, low
// word first, in steps of 1 / FIELD_FIXED. Integers may be added in any order.
#define FIELD_FIXED 1048576.0f
#define FIELD_FIXED_WORDS 8u

#define FIELD_NORMS 5u         // float4 of each partial sum of norms (norms.clh)
#define FIELD_NORM_CHUNK 256u  // texel sides of a partial sum
#define FIELD_TILE_CHUNK 4u    // tiles, or rows of cells, of one

#endif
