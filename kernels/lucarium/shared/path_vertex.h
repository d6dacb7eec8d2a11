// SPDX-License-Identifier: Apache-2.0
// A vertex of a path, kept so that others can connect to it.
#ifndef LUCARIUM_SHARED_PATH_VERTEX_H
#define LUCARIUM_SHARED_PATH_VERTEX_H
#include "lucarium/shared/dialect.h"

// flags: bits of Bsdf::flags (0 to 7), PATH_VERTEX_*, and from bit 16 the number of the vertex on its path, from 1; a
// number of 0 means that there is none.
#define PATH_VERTEX_BSDF_FLAGS 0xffu
#define PATH_VERTEX_FRONT 0x100u    // the light comes from the front of the triangle
#define PATH_VERTEX_CAUSTIC 0x200u  // the light has come here by ideal surfaces alone, one or more
#define PATH_VERTEX_NUMBER_SHIFT 16u

// With its BSDF, made with the direction of the light as view (bsdf.clh): textures are not looked up again.
LUCARIUM_STRUCT_BEGIN(PathVertex)
float4 position;      // xyz where rays leave the surface (Surface::ray_start) [m]; w: PathMis::fixed
float4 flux;          // xyz: what arrives over |n_g.w_i| [lm]; w: PathMis::turning
float4 normal;        // xyz geometric normal on the light's side; w: alpha
float4 shading;       // xyz shading normal; w: eta, of thin walls their index of refraction
float4 view;          // xyz unit direction w_i to where the light comes from; w: bits of the flags
float4 diffuse;       // xyz; w: bits of the medium on that side
float4 f0;            // xyz; w: bits of the world triangle
float4 transmission;  // xyz; w: bits: f90 in 65535ths (low half), Surface::ray_offset rounded up (high half)
LUCARIUM_STRUCT_END(PathVertex, 128)

#endif
