// SPDX-License-Identifier: Apache-2.0
// Memory layout of the voxel grid and the three A-buffers (structure/voxel_abuffer.h), which host and kernels share.
//
// Grid coordinates are in pixels, from the grid's lower corner. The A-buffer of axis k looks along +k; its columns are
// (x, y) = (coordinate k + 1, coordinate k + 2), modulo 3. Voxels are cubes of `voxels.w` pixels.
#ifndef VOXEL_ABUFFER_SHARED_ABUFFER_LAYOUT_H
#define VOXEL_ABUFFER_SHARED_ABUFFER_LAYOUT_H
#include "lucarium/shared/dialect.h"

LUCARIUM_STRUCT_BEGIN(AbufferGrid)
float4 center;  // xyz: what world positions are taken relative to [m]; w: edge of a pixel [m]
float4 corner;  // xyz: lower corner of the grid relative to it [m]; w: pixels per metre
uint4 voxels;   // xyz: along each axis; w: pixels per edge
uint4 bricks;   // xyz: of 4 × 4 × 4 voxels along each axis; w: entries of the start table per axis
float slack;    // how far rounding may move a position [pixels]
uint triangles;
float per_edge;  // voxels per pixel
uint pad0;
LUCARIUM_STRUCT_END(AbufferGrid, 80)

// Where the plane of a triangle lies in the columns of its dominant axis, in grid coordinates.
LUCARIUM_STRUCT_BEGIN(AbufferPlane)
float4 anchor;  // xyz: column and depth of a corner; w: half the depth that the plane passes in a column
float4 slope;   // xy: depth per column; z, w: least and greatest depth of the triangle
LUCARIUM_STRUCT_END(AbufferPlane, 32)

// Beside a fragment's depth and triangle where attributes are stored: 32 bytes together (Hu et al. 2014, section 3.1).
LUCARIUM_STRUCT_BEGIN(AbufferAttributes)
float u, v;                          // the position: barycentrics of the pixel's centre
float normal_x, normal_y, normal_z;  // of the triangle, unnormalised, on its front side
uint material;
LUCARIUM_STRUCT_END(AbufferAttributes, 24)

// Classes of triangles (LayeredView::classes): those of axis k for exact search, and those for parity.
#define ABUFFER_EXACT(k) (1u << (k))
#define ABUFFER_PARITY 8u
#define ABUFFER_ROOM 16u    // with ABUFFER_PARITY: fronts face inwards
#define ABUFFER_OPEN 64u    // with ABUFFER_PARITY: the component has no inside
#define ABUFFER_ABSENT 32u  // of components, alone: not of this structure's subset; their triangles have no class

// A fragment for parity: its triangle; bit 30: of an open component; bit 31: it faces along the axis (LAYERED_AWAY).
#define ABUFFER_TRIANGLE 0x3fffffffu
#define ABUFFER_OPEN_FRAGMENT 0x40000000u

// The state of a point: what closed components count, and this many times what open ones do, in its column.
#define ABUFFER_OPEN_STEP 65536

// A voxel's word: bits 0, 1, 2: triangles for exact search in the columns of that axis; bit 3: triangles for parity;
// bits 4, 5: the axis by whose columns it is searched for parity, 3: any; bits 6 and above: its first cell block, one
// for each bit of 0, 1, 2, 3 in turn.
#define ABUFFER_EXACT_AXES 7u
#define ABUFFER_OCCUPIED 15u
#define ABUFFER_AXIS_SHIFT 4u
#define ABUFFER_CELLS_SHIFT 6u

// A cell block says which of a voxel's 8 × 8 × 8 cells the depth intervals of exact fragments of one axis touch, or, of
// bit 3, in which cells the state of points changes along its axis, or along all axes where that is 3. Word 8 m + j is
// the slice j across axis m: bit 8 c + b for the coordinates b along m + 1 and c along m + 2, modulo 3.
#define ABUFFER_CELL_WORDS 24u
#define ABUFFER_CELLS 8u  // along an edge of a voxel

// Triangle t, as a leaf block of one triangle (lucarium/shared/bvh_layout.h), starts at word t ·
// ABUFFER_TRIANGLE_WORDS.
#define ABUFFER_TRIANGLE_WORDS 10u

// Depths of exact fragments are kept as an interval in steps of 1/16 pixel: the least depth rounded down in the low 16
// bits, and in the high 16 this number less the greatest depth rounded up, so that one kind of comparison serves both
// ends.
#define ABUFFER_DEPTH_STEPS 16.0f
#define ABUFFER_DEPTH_LAST 65535.0f

// Voxels along an edge of the grid, at most: as many as pixels (LAYERED_MAX_EDGE).
#define ABUFFER_MAX_VOXELS 4096
// Pixels along an edge of a voxel, at most.
#define ABUFFER_MAX_VOXEL_EDGE 256

// Words behind the last fragment that vector loads may read.
#define ABUFFER_PADDING 16u

// Counts that a build leaves.
#define ABUFFER_COUNT_EXACT 3u   // 0 … 3: first exact fragment of each axis, and their number
#define ABUFFER_COUNT_PARITY 7u  // 4 … 7: the same of fragments for parity
#define ABUFFER_COUNT_UNBALANCED 8u
#define ABUFFER_COUNT_CELLS 9u     // cell blocks
#define ABUFFER_COUNT_LONGEST 10u  // fragments of the longest list
#define ABUFFER_COUNT_FILLED 11u   // columns that have any fragments
#define ABUFFER_COUNTS 16u

// What searches count with ABUFFER_COUNT_WORK.
#define ABUFFER_WORK_RAYS 0u        // searches begun: two per ray where there are both classes of triangles
#define ABUFFER_WORK_VOXELS 1u      // steps to the next voxel, or over empty ones
#define ABUFFER_WORK_COLUMNS 2u     // columns looked at, points for sampled searches
#define ABUFFER_WORK_BISECTIONS 3u  // further points for bisection
#define ABUFFER_WORK_TRIANGLES 4u   // triangle tests
#define ABUFFER_WORK_STARTS 5u      // rays whose state is the same on both sides of the surface that they leave
#define ABUFFER_WORK_FACINGS 6u     // changes of state that no triangle explains
#define ABUFFER_WORK_COUNTS 7u

#endif
