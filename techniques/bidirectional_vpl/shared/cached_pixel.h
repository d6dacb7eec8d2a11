// SPDX-License-Identifier: Apache-2.0
// Indirect light that is kept from frame to frame.
#ifndef BIDIRECTIONAL_VPL_SHARED_CACHED_PIXEL_H
#define BIDIRECTIONAL_VPL_SHARED_CACHED_PIXEL_H
#include "lucarium/shared/dialect.h"

#define BIDIRECTIONAL_SUB_PIXELS 4u  // of a pixel, 2 x 2, each with a cache; one of them is new in a frame

// What a sub-pixel saw, and its light.
LUCARIUM_STRUCT_BEGIN(CachedPixel)
float4 position;  // xyz [m]; w: 1, or 0 where nothing can be used again
float4 normal;    // xyz geometric normal
float4 light;     // xyz sum [cd/m^2]; w: samples
LUCARIUM_STRUCT_END(CachedPixel, 48)

#endif
