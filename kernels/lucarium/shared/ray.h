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

// The surfaces that a ray leaves and is to reach, for intersectors that want to know (Intersector::wants_ends): a world
// triangle each, LUCARIUM_NONE where there is none (a camera, a punctual light, the infinite) or none is known. The
// front of a triangle is the side from which its corners are counter-clockwise. Of an inactive ray they mean nothing.
#define LUCARIUM_RAY_END_BACK \
  0x80000000u  // start: the ray leaves on the back side of the triangle; end: the point on
               // the triangle is reached from its back side

LUCARIUM_STRUCT_BEGIN(RayEnds)
uint start;  // the triangle off which the origin lies, and the side
uint end;    // the triangle off which the ray's last point lies, and the side
LUCARIUM_STRUCT_END(RayEnds, 8)

#endif
