// SPDX-License-Identifier: Apache-2.0
#ifndef LUCARIUM_SHARED_GBUFFER_H
#define LUCARIUM_SHARED_GBUFFER_H
#include "lucarium/shared/dialect.h"

#define LUCARIUM_GBUFFER_MISS 0u
#define LUCARIUM_GBUFFER_SURFACE 1u

// The first non-delta point seen through a pixel. Of a surface, view.w, emission.w and albedo.w are red, green and blue
// of its diffuse lobe's albedo: gbuffer_diffuse().
LUCARIUM_STRUCT_BEGIN(GBufferPoint)
float4 position;    // xyz [m]; w: length of the whole eye path [m]
float4 normal;      // xyz geometric normal on the side of view; w: 1 when the back of the triangle is seen, else 0
float4 shading;     // xyz shading normal; w: 0, or 1 + the material of the volume (medium.clh) it is seen through
float4 view;        // xyz unit direction from the point towards where the ray came from
float4 throughput;  // xyz of the delta chain (1 without one); w: number of delta events
float4 emission;    // xyz radiance emitted along the eye path towards the eye, throughput included [cd/m²]
float4 albedo;      // xyz: what the surface reflects of white light from everywhere, over its hemisphere
float u, v;         // barycentrics of the hit
uint triangle;      // LUCARIUM_NONE for a miss
uint state;         // LUCARIUM_GBUFFER_*
LUCARIUM_STRUCT_END(GBufferPoint, 128)

#endif
