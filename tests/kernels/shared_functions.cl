// SPDX-License-Identifier: Apache-2.0
#include "lucarium/shared/hash.h"
#include "lucarium/shared/radical_inverse.h"
#include "lucarium/shared/sobol_points.h"
#include "lucarium/shared/triangle_map.h"

// Every shared function of word i: see shared_functions_test.cpp.
kernel void call_shared_functions(const global uint* words, const uint count, global uint4* results,
                                  global float4* weights) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const uint a = words[i], b = hash_uint(a);
  results[4 * i] = (uint4)(b, hash_uint2(a, b), hash_uint3(a, b, i), reverse_bits(a));
  results[4 * i + 1] = hash_uint4((uint4)(a, b, i, 7u));
  results[4 * i + 2] = owen_scramble_reversed(sobol_reversed(a), (uint4)(b, a, i, 3u));
  results[4 * i + 3] = reverse_bits4(sobol_reversed(a));
  weights[i] =
      (float4)(sample_triangle((float2)(uint_to_unit(a), uint_to_unit(b))), uint_to_unit(a), radical_inverse(a, 3u));
}
