// SPDX-License-Identifier: Apache-2.0
// Radical inverses, the same for host and device: Halton and Hammersley points.
#ifndef LUCARIUM_SHARED_RADICAL_INVERSE_H
#define LUCARIUM_SHARED_RADICAL_INVERSE_H
#include "lucarium/shared/functions.h"

LUCARIUM_SHARED_BEGIN

// Radical inverse of `index` in a base >= 2, of [0, 1).
LUCARIUM_SHARED_FUNCTION float radical_inverse(uint index, uint base) {
  const float inverse = 1.0f / (float)base;
  float scale = 1.0f;
  uint reversed = 0;
  // Stop before the reversed digits overflow; what they leave out is below 2^-24 for every base of the table.
  const uint limit = 0xffffffffu / base - base;
  while (index && reversed < limit) {
    const uint next = index / base;
    reversed = reversed * base + (index - next * base);
    scale *= inverse;
    index = next;
  }
  const float value = (float)reversed * scale;
  return value < 0x1.fffffep-1f ? value : 0x1.fffffep-1f;
}

LUCARIUM_SHARED_END

#endif
