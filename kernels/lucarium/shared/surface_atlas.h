// SPDX-License-Identifier: Apache-2.0
// The surface atlas as kernels see it: every point of every triangle has a texel. Built by SurfaceAtlas
// (framework/lucarium/services/surface_atlas/surface_atlas.h), read through kernels/lucarium/surface_atlas.clh.
//
// A texel is a small patch of one surface. A *texel side* is one reflecting side of a texel; with K double-sided texels
// the texel sides are [0, K) their fronts, [K, 2K) their backs (back = front + K), [2K, texel_count) single-sided
// fronts. The id of a texel is the texel side of its front. Double-sided here means that light is reflected or
// transmitted on both sides.
#ifndef LUCARIUM_SHARED_SURFACE_ATLAS_H
#define LUCARIUM_SHARED_SURFACE_ATLAS_H
#include "lucarium/shared/dialect.h"

// How to find the texel of a point of one world triangle: uv interpolated between the corners, clamped to their box,
// then texel = atlas_table[base + (uint)v * LUCARIUM_ATLAS_PITCH(triangle) + (uint)u].
LUCARIUM_STRUCT_BEGIN(AtlasTriangle)
float u0, v0, u1, v1, u2, v2;  // of the corners [cells], relative to the integer minimum of the triangle
uint base;                     // cell of that minimum
uint pitch_key;                // LUCARIUM_ATLAS_PITCH and, above it, LUCARIUM_ATLAS_KEY
LUCARIUM_STRUCT_END(AtlasTriangle, 32)

// Cells per row of its chart; 0: a chart of one texel (uv are constant).
#define LUCARIUM_ATLAS_PITCH_BITS 26u
#define LUCARIUM_ATLAS_PITCH(triangle) ((triangle).pitch_key & ((1u << LUCARIUM_ATLAS_PITCH_BITS) - 1u))
// By which near triangles differ: their number modulo 64, which leaves out triangles that rays cannot hit, so that
// they change nothing.
#define LUCARIUM_ATLAS_KEY(triangle) ((triangle).pitch_key >> LUCARIUM_ATLAS_PITCH_BITS)

// One side. The sample position lies on the texel's largest piece of a triangle.
LUCARIUM_STRUCT_BEGIN(AtlasTexel)
uint triangle;  // world triangle of the sample position
float b1, b2;   // its barycentrics (weights of corners 1 and 2)
float area;     // of the texel on this side [m²]
LUCARIUM_STRUCT_END(AtlasTexel, 16)

// The part of a triangle that belongs to a texel; pieces of all texels sum to 1 over each triangle that rays can hit.
LUCARIUM_STRUCT_BEGIN(TexelPiece)
uint triangle;
float fraction;  // of the triangle's area [1]
LUCARIUM_STRUCT_END(TexelPiece, 8)

// A point of a texel.
LUCARIUM_STRUCT_BEGIN(AtlasSample)
uint triangle;  // world triangle
float b1, b2;   // barycentrics (weights of corners 1 and 2)
LUCARIUM_STRUCT_END(AtlasSample, 12)

LUCARIUM_STRUCT_BEGIN(AtlasInfo)
uint texel_count;         // texel sides
uint double_sided_count;  // K
uint cell_count;          // entries of atlas_table
float texel_edge;         // s, the wanted edge of a texel [m]
LUCARIUM_STRUCT_END(AtlasInfo, 16)

// What a texel side scatters and emits, at its sample position, seen along the normal of its side. Names as in
// kernels/lucarium/bsdf.clh.
LUCARIUM_STRUCT_BEGIN(AtlasMaterial)
float4 diffuse;       // xyz: albedo of the Lambert lobe; w: GGX width alpha, 0 for ideal lobes
float4 f0;            // xyz: Schlick's F0 of the reflection lobe; w: f90
float4 transmission;  // xyz: tint of the transmission lobe before 1 - F; w: relative index of refraction eta
float4 emission;      // xyz: radiance emitted towards the normal [cd/m²]; w: 1 when some lobe is ideal, else 0
float4 shading;       // xyz: unit shading normal on this side; w: F0 of the dielectric interface alone
LUCARIUM_STRUCT_END(AtlasMaterial, 80)

// Bits of atlas_links[cell]: the surface goes on from this cell into its neighbour at du, dv in {-1, 0, 1}, so that
// interpolation may use that one. Bit 3 (dv + 1) + du + 1, less one behind the middle.
#define LUCARIUM_ATLAS_LINK(du, dv) (1u << (3 * ((dv) + 1) + (du) + 1 - (3 * (dv) + (du) > 0 ? 1 : 0)))

#endif
