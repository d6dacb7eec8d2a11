// SPDX-License-Identifier: Apache-2.0
// One direction's step of glossy reflection from directions to directions (send_history.cl).
#ifndef BUNDLE_EXCHANGE_SHARED_HISTORY_STEP_H
#define BUNDLE_EXCHANGE_SHARED_HISTORY_STEP_H
#include "lucarium/shared/dialect.h"

LUCARIUM_STRUCT_BEGIN(HistoryStep)
uint index;      // of the direction in the history
uint length;     // directions that the history has room for
uint reflected;  // directions before it that are reflected
uint first;      // 1: the first direction of a batch
uint by_share;   // 1: normalized by the sum of weights, 0: by their number
uint by_area;    // 1: w holds the area of a ray, 0: a texel side has one ray and w its cosine
uint adds;       // 1: records already hold what texel sides send otherwise
uint pad;
LUCARIUM_STRUCT_END(HistoryStep, 32)

#endif
