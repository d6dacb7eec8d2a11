// SPDX-License-Identifier: Apache-2.0
// Ray and hit records of every Intersector.
#ifndef LUCARIUM_SHARED_RAY_H
#define LUCARIUM_SHARED_RAY_H
#include "lucarium/shared/dialect.h"

#define LUCARIUM_NO_HIT 0xffffffffu

// Seed of a ray to which BLEND surfaces are opaque (path set without BLEND); other rays' seeds differ from it.
#define LUCARIUM_SEED_OPAQUE 0u

LUCARIUM_STRUCT_BEGIN(Ray)
float4 origin;     // xyz: origin, world space [m], off its surface already; w: bits of a uint seed that decides
                   // stochastic transparency (BLEND) along this ray
float4 direction;  // xyz: direction, unit length; w: largest distance that counts [m], may be INFINITY;
                   // negative: the ray is inactive and its result is a miss
LUCARIUM_STRUCT_END(Ray, 32)

LUCARIUM_STRUCT_BEGIN(Hit)
float distance;  // along the unit direction [m]; INFINITY for a miss
uint triangle;   // world-space triangle index, LUCARIUM_NO_HIT for a miss
float u;         // barycentric weight of the second vertex
float v;         // barycentric weight of the third vertex
LUCARIUM_STRUCT_END(Hit, 16)

#endif
