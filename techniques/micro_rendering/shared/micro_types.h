// SPDX-License-Identifier: Apache-2.0
// What the kernels of micro_rendering share with each other and with C++: the data structures of Ritschel et al. 2009,
// section 3.1. Its node of 128 bits has centre and radius in 4 × 16 bits, normal and albedo in 15 bits each, 8 bits of
// cone; here the albedo is kept apart (leaf_albedo).
//
// A tree has n = 2^depth leaves in heap order: root 1, children of i are 2i and 2i + 1, leaves n … 2n - 1; level l is
// [2^l, 2^(l+1)). Node i of a tree is nodes[tree.first_node + i], its radiance radiance[tree.first_node + i]; leaf j is
// node n + j, and number tree.first_node / 2 + j in buffers over all leaves. Entry 0 of a tree is unused.
//
// node (uint4, 16 B), in the tree's grid coordinates (below):
//   x   centre x (16 bits), centre y << 16
//   y   centre z (16 bits), half the radius as a half << 16
//   z   octahedral normal 2 x 10 bits, cone half angle << 20 (8 bits, of pi / 255), flags << 28
//   w   a line where the surface ends, as the plane through it: octahedral normal 2 x 8 bits, 1 + distance from the
//       centre << 16 (8 bits, of radius / 254), 0 none; << 24: of a leaf on a two-sided triangle its side of a sheet
//       (MICRO_SIDE), else 0; of an inner node the area that it shows along its axis over that of its surface [255]
// Radius and cone angle are rounded up by what centre and normal lost.
//
// radiance (half4, 8 B):
//   xyz radiance towards the front [units of radiance_unit[0] cd/m²], mean over the leaves by area
//   w   largest difference of any leaf's radiance (largest channel) below the node, for error-driven cuts.
//
// Grid coordinates: world coordinates after translation, rotation and uniform scaling, so that the cube about the
// tree's points becomes [0, 65535]^3. Angles are those of the world, so that a gather that maps its position and frame
// into the grid needs no further scaling: a centre is its three integers.
#ifndef MICRO_RENDERING_SHARED_MICRO_TYPES_H
#define MICRO_RENDERING_SHARED_MICRO_TYPES_H
#include "lucarium/shared/dialect.h"

#define MICRO_LARGEST_RADIUS 131008.0f  // of a node [grid steps]: twice the largest half
#define MICRO_GRID 65535.0f             // steps of the grid along each side of its cube
#define MICRO_CONE_STEPS 255u           // of pi

#define MICRO_NODE_CULLABLE \
  1u                        // seen from behind there is nothing (a twin shows its front), or black is not wanted there
#define MICRO_NODE_TWIN 2u  // one side of a double-sided triangle

// One hierarchy: what rests, or one moving instance.
LUCARIUM_STRUCT_BEGIN(MicroTree)
float4 grid_row0, grid_row1, grid_row2;  // grid_from_world, 3 x 4, a similarity
float4 origin_step;  // xyz: tree space's point at grid (0, 0, 0); w: tree-space length of one grid step
uint first_node;     // in nodes and radiance
uint depth;          // levels below the root
float leaf_area;     // mean surface area that a leaf stands for [grid steps²]
float world_step;    // length of one grid step [m]
LUCARIUM_STRUCT_END(MicroTree, 80)

// Where a leaf lies on its triangle. Leaves do not move on it.
LUCARIUM_STRUCT_BEGIN(MicroLeaf)
uint triangle;  // world triangle; MICRO_LEAF_BACK: on its back; MICRO_LEAF_SOLID: only the inside of a solid sees its
                // back
uint weights;   // barycentric weights of the second and third vertex, 16 bits each, of 65535
float area;     // of the triangle when the leaf was placed [tree space²]
LUCARIUM_STRUCT_END(MicroLeaf, 12)

#define MICRO_LEAF_BACK 0x80000000u
#define MICRO_LEAF_SOLID 0x40000000u
#define MICRO_LEAF_TRIANGLE 0x3fffffffu  // the triangle's number alone

#define MICRO_CUT_LEVELS 6u  // most levels that the cut of gathering nodes reaches below its level

// Glossy lobe of a leaf (node_shading=dynamic); ideal ones are left out.
LUCARIUM_STRUCT_BEGIN(MicroLeafLobe)
uint normal;      // shading normal, octahedral, 2 x 16 bits
uint fresnel[2];  // 4 halfs: f0 per channel, f90
float alpha;      // GGX width; 0: none
LUCARIUM_STRUCT_END(MicroLeafLobe, 16)

// The light sample that a leaf keeps (node_shading=dynamic).
LUCARIUM_STRUCT_BEGIN(MicroLeafLight)
float4 direction;  // xyz unit, towards the light; w: sum of the luminances of all samples' irradiance [lx]
float4 color;      // xyz: irradiance of this sample over its luminance
LUCARIUM_STRUCT_END(MicroLeafLight, 32)

// What a node keeps of the leaves below it (node_shading=dynamic).
LUCARIUM_STRUCT_BEGIN(MicroNodeChoice)
uint leaf;        // one of them, by its number in buffers over all leaves
float luminance;  // mean luminance of the irradiance over the area of all of them [lx]
LUCARIUM_STRUCT_END(MicroNodeChoice, 8)

#define MICRO_CLIPS 4  // lines that bound the disc of a leaf

// A triangle and its neighbours, by world triangle.
LUCARIUM_STRUCT_BEGIN(TriangleEdges)
uint ends[8];  // MICRO_CLIPS pairs of vertices, as the triangle they are of is wound: edges where the surface ends or
               // bends away; LUCARIUM_NONE: no more
uint own;      // so many of them are edges of the triangle itself
uint sheet;    // of a two-sided triangle: 1 ... 127, the same for all that are joined to it and wound alike; else 0
LUCARIUM_STRUCT_END(TriangleEdges, 40)

// Side of a sheet: 0 where sheet is.
#define MICRO_SIDE(sheet, back) ((sheet) ? ((sheet) << 1) | ((back) ? 1u : 0u) : 0u)

// clips (uint4 per leaf): MICRO_CLIPS lines that bound the disc; each a word: 0 none, else the angle of its outward
// normal [2^16 of a turn] about the node's normal, from the tangent of make_basis, and 1 + its distance from the centre
// << 16 [65534 of the node's radius].

// How a tree's leaves are derived from the scene.
LUCARIUM_STRUCT_BEGIN(MicroLeafRules)
uint tree;          // number of the tree
uint object_space;  // 1: tree space is the object space of the instance, 0: the world
float disc_radius;  // of a leaf on a triangle whose area has not changed [tree space]
uint all_cullable;  // 1: nothing is black from behind
float min_area;     // share of a disc that lines leave of it at least: the area that the leaf stands for
LUCARIUM_STRUCT_END(MicroLeafRules, 20)

// A point at which light is gathered. Directions are octahedral, 2 x 16 bits (micro_node.clh).
LUCARIUM_STRUCT_BEGIN(MicroGather)
float4 position;  // xyz [m], world space; w: bits of the index of its result (pixel; node of a cut)
uint normal;      // shading normal: axis of the frame
uint geometric;   // geometric normal on the same side; nothing arrives from below it
uint view;    // unit, towards the viewer (specular lobe only); through a surface: mirrored at it to the normal's side
uint lobes;   // B_d (8 bits), B_s << 8: micro-buffer edges of the diffuse and the specular lobe, 0: none;
              // GGX alpha as a half << 16
float eta;    // 0: the specular lobe reflects; above, it refracts: index of the viewer's side over that of this side;
              // below, it reflects inside a medium: minus the index of this side over that of the other, denser than it
uint hidden;  // MICRO_SIDE of the other side of the surface, which is not seen from near; 0: none
uint pad0, pad1;
LUCARIUM_STRUCT_END(MicroGather, 48)

// Results of a gather, at its index:
//   irradiance  float4: xyz E, light arriving times cosine [lx]; w: share of the hemisphere (by mass) that stayed empty
//   specular    2 float4: xyz of S and S_w [cd/m²]; w: 0. What leaves by the specular lobe is F0 (S - S_w) + F90 S_w,
//               since Schlick's F = F0 + (F90 - F0) w: S sums L G2 / G1 over the lobe's micro-buffer, S_w that times w.
//               Through a rough surface (another index): (1 - F0) S - (F90 - F0) S_w, of the dielectric.
//   sky         (MICRO_GATHER_ENV) 3 float4: the same three of the environment seen through empty micro-pixels
//   levels      (MICRO_LEVELS, read) float4: x y running means of the diffuse and the specular micro-buffer, brightest
//               channel [cd/m²], 0: none yet; z: sum of their sum's squared deviations from its mean; w: of how many
//               frames, below 0 where the last cut was flat
//   statistics  MicroStatistics
LUCARIUM_STRUCT_BEGIN(MicroStatistics)
uint visits;      // nodes tested
uint splats;      // nodes projected
uint listed;      // leaves kept for ray casting
uint disc_tests;  // ray-disc tests
uint holes;       // micro-pixels that stayed empty, before they were filled
uint flushes;     // lists that were full
uint levels;      // sum of the levels of the nodes of the cut
uint uneven;      // 1: some node was not flat enough for a coarse cut (MICRO_ERROR_CUT)
LUCARIUM_STRUCT_END(MicroStatistics, 32)

// The gather kernel, micro_gather.cl, is bound by gather_pass.cpp by these names:
//   __kernel void gather_light(__global const MicroTree* trees, uint tree_count, __global const uint4* nodes,
//                           __global const half* radiance, __global const uint4* clips,
//                           __global const float* radiance_unit,
//                           __global const MicroGather* gathers, __global const uint* gather_count,
//                           MicroSettings settings, __global float4* irradiance, __global float4* specular,
//                           __global MicroStatistics* statistics, __global float4* micro_buffer,
//                           [MICRO_LEVELS: __global const float4* levels,]
//                           [MICRO_GATHER_ENV: LUCARIUM_SCENE_PARAMETERS __global float4* sky,]
//                           [MICRO_DYNAMIC: __global const MicroNodeChoice* choices,
//                           __global const MicroLeafLight* leaf_lights, __global const MicroLeafLobe* leaf_lobes,]
//                           uint slice_base)
// Work-item i is gather settings.first + i; it returns when i >= gather_count[0]. Results that no gather
// has stay as they were. Rules that a program fixes come as definitions (gather_pass.cpp).

// What changes from one gather pass to the next, or needs no program of its own.
LUCARIUM_STRUCT_BEGIN(MicroSettings)
float kappa;         // threshold on a node's solid angle, in micro-pixels
float splat_radius;  // c_s: radius of a splat in those of the disc of the node's area
uint seed;           // of the jitter and of the frames; another one for every iteration
uint inspect;        // result whose micro-buffer is wanted, LUCARIUM_NONE: none
float cut_error;     // share of a micro-buffer's mean that a node may err by (MICRO_ERROR_CUT)
uint first;          // gather of the first work-item
uint inspect_too;    // another such result
float pad0;
LUCARIUM_STRUCT_END(MicroSettings, 32)

#endif
