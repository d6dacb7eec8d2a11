// SPDX-License-Identifier: Apache-2.0
// What pixels of a walk need of triangles, materials and texel sides, side by side in memory.
#ifndef VIRTUAL_LIGHT_FIELD_SHARED_WALK_TABLES_H
#define VIRTUAL_LIGHT_FIELD_SHARED_WALK_TABLES_H
#include "lucarium/shared/dialect.h"
#include "lucarium/shared/surface_atlas.h"

// Of a world triangle, a cache line.
LUCARIUM_STRUCT_BEGIN(WalkTriangle)
AtlasTriangle atlas;
float normal_x, normal_y, normal_z;  // unit geometric normal on its front
float limit;  // shading normals face a viewer whose direction has a larger cosine with the geometric normal; above 1:
              // the triangle needs more than these tables
uint material;
uint pad0, pad1, pad2;
LUCARIUM_STRUCT_END(WalkTriangle, 64)

// Of the front of material m (entry 2 m) or its back (2 m + 1), if neither textures nor vertex colours change it.
LUCARIUM_STRUCT_BEGIN(WalkSide)
float4 diffuse;  // xyz: albedo of its diffuse lobe; w: 1: its specular lobe is ideal, else 0
float4 emitted;  // xyz: radiance that it emits [cd/m^2]
LUCARIUM_STRUCT_END(WalkSide, 32)

// Of an entry of the field's lists of light (side_halves.clh), a cache line.
LUCARIUM_STRUCT_BEGIN(WalkLight)
float4 shown, direct;  // LightField::shown(), shown_direct()
float4 coat;           // xyz: albedo of a coat that is folded into diffuse light; w: bits of the facet, LUCARIUM_NONE
float4 pad;
LUCARIUM_STRUCT_END(WalkLight, 64)

#define WALK_NEVER 2.0f  // WalkTriangle::limit of a triangle whose pixels are shown one by one

#endif
