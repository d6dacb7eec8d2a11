// SPDX-License-Identifier: Apache-2.0
// Integer hashes, the same for host and device.
#ifndef LUCARIUM_SHARED_HASH_H
#define LUCARIUM_SHARED_HASH_H
#include "lucarium/shared/functions.h"

LUCARIUM_SHARED_BEGIN

// A bijective mix of 32 bits (O'Neill 2014, PCG RXS-M-XS; recommended as a hash by Jarzynski and Olano, JCGT 2020).
LUCARIUM_SHARED_FUNCTION uint hash_uint(uint x) {
  x = x * 747796405u + 2891336453u;
  const uint word = ((x >> ((x >> 28) + 4u)) ^ x) * 277803737u;
  return (word >> 22) ^ word;
}
LUCARIUM_SHARED_FUNCTION uint hash_uint2(uint a, uint b) { return hash_uint(a + hash_uint(b)); }
LUCARIUM_SHARED_FUNCTION uint hash_uint3(uint a, uint b, uint c) { return hash_uint(a + hash_uint(b + hash_uint(c))); }

// Four well-mixed words of four words (PCG4D, Jarzynski and Olano, JCGT 2020).
LUCARIUM_SHARED_FUNCTION uint4 hash_uint4(uint4 v) {
  v = v * 1664525u + 1013904223u;
  v.x += v.y * v.w;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  v.w += v.y * v.z;
  v ^= v >> 16;
  v.x += v.y * v.w;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  v.w += v.y * v.z;
  return v;
}

// The upper 24 bits as a number of [0, 1): exact, never 1.
LUCARIUM_SHARED_FUNCTION float uint_to_unit(uint x) { return (float)(x >> 8) * 5.9604644775390625e-8f; }

LUCARIUM_SHARED_END

#endif
