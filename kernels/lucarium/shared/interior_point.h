// SPDX-License-Identifier: Apache-2.0
#ifndef LUCARIUM_SHARED_INTERIOR_POINT_H
#define LUCARIUM_SHARED_INTERIOR_POINT_H
#include "lucarium/shared/dialect.h"

// A point of which PointInterior measures whether it is inside (framework/lucarium/services/interior_surfaces).
LUCARIUM_STRUCT_BEGIN(InteriorPoint)
uint triangle;  // world triangle; INTERIOR_BACK: the point is on its back
float u, v;     // barycentrics
LUCARIUM_STRUCT_END(InteriorPoint, 12)

#define INTERIOR_BACK 0x80000000u
#define INTERIOR_TRIANGLE 0x7fffffffu

#define INTERIOR_MAX_SAMPLES 32u  // of a texel side: TexelInterior has a bit for each

#endif
