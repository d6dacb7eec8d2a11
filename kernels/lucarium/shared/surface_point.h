// SPDX-License-Identifier: Apache-2.0
#ifndef LUCARIUM_SHARED_SURFACE_POINT_H
#define LUCARIUM_SHARED_SURFACE_POINT_H
#include "lucarium/shared/dialect.h"

// A receiver on a surface, independent of any view.
#define LUCARIUM_POINT_TRANSMITS 1u  // what it lies on transmits light

LUCARIUM_STRUCT_BEGIN(SurfacePoint)
float4 position;  // xyz [m]; w unused
float4 normal;    // xyz unit normal of the receiving side (geometric); w unused
float u, v;       // barycentrics
uint triangle;    // world triangle it lies on
uint flags;       // LUCARIUM_POINT_*, of texels of the surface atlas; else 0
LUCARIUM_STRUCT_END(SurfacePoint, 48)

#endif
