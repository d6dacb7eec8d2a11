// SPDX-License-Identifier: Apache-2.0
// The map from the unit square to a triangle, the same for host and device.
#ifndef LUCARIUM_SHARED_TRIANGLE_MAP_H
#define LUCARIUM_SHARED_TRIANGLE_MAP_H
#include "lucarium/shared/functions.h"

LUCARIUM_SHARED_BEGIN

// A uniform point of a triangle as barycentric weights (v1, v2) like Hit's u and v; Heitz 2019, "A Low-Distortion Map
// Between Triangle and Square".
LUCARIUM_SHARED_FUNCTION float2 sample_triangle(float2 u) {
  if (u.y > u.x) {
    const float x = 0.5f * u.x;
    return LUCARIUM_FLOAT2(x, u.y - x);
  }
  const float y = 0.5f * u.y;
  return LUCARIUM_FLOAT2(u.x - y, y);
}

LUCARIUM_SHARED_END

#endif
