// SPDX-License-Identifier: Apache-2.0
// What LayeredRaster (framework/lucarium/services/layered_raster/layered_raster.h) and its kernels share: views,
// records, sort keys.
#ifndef LUCARIUM_SHARED_LAYERED_RASTER_H
#define LUCARIUM_SHARED_LAYERED_RASTER_H
#include "lucarium/shared/dialect.h"

// A view: world point p at pixel coordinates (X/W, Y/W), X = row_x · (p, 1) and so on; pixel (i, j) has its centre at
// (i + 1/2, j + 1/2), j downwards. Orthographic: W = 1 and the depth is row_w · (p, 1); perspective: W = depth =
// row_w · (p, 1), and what is nearer than depth_min is clipped. row_x × row_y must point along row_w (x right, y down,
// depth away from the viewer).
LUCARIUM_STRUCT_BEGIN(LayeredView)
float4 row_x, row_y, row_w;
float depth_min;     // depth range of the view: sorting resolves (depth_max - depth_min) / 2^22
float depth_scale;   // 1 / (depth_max - depth_min)
uint width, height;  // pixels, at most those of the LayeredRaster
uint seed;           // decides BLEND together with triangle and pixel
uint classes;        // with LayeredRasterOptions::classes: triangles are drawn whose class byte shares a bit with it
uint pad0, pad1;
LUCARIUM_STRUCT_END(LayeredView, 80)

// A triangle set up for one view, in units of 1/256 pixel. Vertices are in counter-clockwise order of (x, y) with y
// downwards reversed where LAYERED_AWAY is not set, so that the doubled area is positive.
LUCARIUM_STRUCT_BEGIN(LayeredRecord)
int4 x;         // xyz: of the vertices; w: first and last pixel column (lower and upper 16 bits)
int4 y;         // xyz: of the vertices; w: first and last pixel row
float4 w;       // xyz: depth of the vertices (orthographic) or 1/W (perspective); w: 1 / doubled area
uint triangle;  // world triangle | LAYERED_AWAY
uint flags;     // LAYERED_RECORD_*
uint clipped;   // which LayeredClip, with LAYERED_RECORD_CLIPPED
uint pad;
LUCARIUM_STRUCT_END(LayeredRecord, 64)

#define LAYERED_AWAY 0x80000000u   // front side faces the view direction: what is seen along it is the back
#define LAYERED_RECORD_ALPHA 1u    // MASK or BLEND material
#define LAYERED_RECORD_LARGE 2u    // extends beyond 64 pixels: its edges need 64 bits
#define LAYERED_RECORD_CLIPPED 4u  // part of a triangle that was clipped

// Barycentric weights (second and third corner of the world triangle) of the vertices of a clipped triangle's part.
LUCARIUM_STRUCT_BEGIN(LayeredClip)
float4 second;  // xyz: of the three vertices
float4 third;
LUCARIUM_STRUCT_END(LayeredClip, 32)

// Stored A-buffer: fragments of pixel p are [pixel_start[p], pixel_start[p + 1]), nearest first.
LUCARIUM_STRUCT_BEGIN(LayeredFragment)
uint triangle;  // world triangle | LAYERED_AWAY
float depth;
LUCARIUM_STRUCT_END(LayeredFragment, 8)

// Sort key: depth in steps of 1 / 2^22 of the view's range, then LAYERED_KEY_TOWARDS, then 6 bits that say where the
// payload is. Nothing: all ones.
// Where two surfaces meet, rounding may swap their depths. What is less than a step apart (up to two may be) counts as
// equal there, and LAYERED_AWAY comes first (a closed room's near wall is before its far wall at their
// edge): keys of the other facing are a step larger, so that it does not matter on which side of a step's border either
// lies.
#define LAYERED_KEY_NONE 0xffffffffu
#define LAYERED_KEY_BUCKET 10
#define LAYERED_KEY_TOWARDS 0x200u  // flag of a fragment that is not LAYERED_AWAY
#define LAYERED_KEY_FACING (LAYERED_KEY_TOWARDS | 1u << LAYERED_KEY_BUCKET)  // what such a fragment adds to its key
#define LAYERED_KEY_LAYER 63u
// Depth in steps.
#define LAYERED_KEY_DEPTH(key) (((key) >> LAYERED_KEY_BUCKET) - ((key) / LAYERED_KEY_TOWARDS & 1u))

#define LAYERED_SUBPIXEL 256    // positions per pixel and axis
#define LAYERED_MAX_EDGE 4096u  // pixels per axis
#define LAYERED_GUARD 16384.0f  // pixels: beyond, triangles are clipped
#define LAYERED_TILE_ROWS 16u   // pixel rows per tile
#ifndef LAYERED_MAX_LAYERS      // of a pixel row of a tile; kernels may be compiled with fewer (LayeredRasterOptions)
#define LAYERED_MAX_LAYERS 64u
#endif
#define LAYERED_BLOCK_WORDS 160u       // of the de-indexed geometry, per 16 triangles
#define LAYERED_BLOCKS_EACH 8u         // of which a work-item of set-up takes that many
#define LAYERED_CLIP_PARTS 6u          // a triangle clipped by five planes has at most eight corners
#define LAYERED_NO_BOUNDS 0x000000ffu  // tile bounds of what is not seen; else x0 | y0 << 8 | x1 << 16 | y1 << 24

// How layered_list_fragments (framework/lucarium/services/layered_raster/lists.cl) writes.
#define LAYERED_MODE_COUNT 0u
#define LAYERED_MODE_FILL 1u
#define LAYERED_MODE_LINK 2u

#endif
