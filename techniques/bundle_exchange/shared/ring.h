// SPDX-License-Identifier: Apache-2.0
// One direction's step of glossy reflection from directions to directions (ring.cl).
#ifndef BUNDLE_EXCHANGE_SHARED_RING_H
#define BUNDLE_EXCHANGE_SHARED_RING_H
#include "lucarium/shared/dialect.h"

LUCARIUM_STRUCT_BEGIN(RingStep)
uint place;     // of the direction in the history
uint length;    // directions that the history has room for
uint known;     // directions before it that are reflected
uint first;     // 1: the first direction of a batch
uint by_share;  // 1: normalized by the sum of weights, 0: by their number
uint by_area;   // 1: w holds the area of a ray, 0: a slot has one ray and w its cosine
uint onto;      // 1: records already hold what slots send otherwise
uint pad;
LUCARIUM_STRUCT_END(RingStep, 32)

#endif
