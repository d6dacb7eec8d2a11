// SPDX-License-Identifier: Apache-2.0
// The hits of two structures over different triangles as those of one.
#include "lucarium/shared/ray.h"

// hits: the nearer one; equal distances go to the lower triangle.
__kernel void abuffer_nearer_hits(__global const uint* counter, uint counter_index, uint capacity,
                                  __global const Hit* others, __global Hit* hits) {
  const uint i = get_global_id(0);
  if (i >= min(counter[counter_index], capacity) || others[i].triangle == LUCARIUM_NO_HIT) return;
  const Hit a = hits[i], b = others[i];
  const bool nearer = b.distance < a.distance || (b.distance == a.distance && b.triangle < a.triangle);
  if (a.triangle == LUCARIUM_NO_HIT || nearer) hits[i] = b;
}

__kernel void abuffer_either_occludes(__global const uint* counter, uint counter_index, uint capacity,
                                      __global const uint* others, __global uint* occluded) {
  const uint i = get_global_id(0);
  if (i < min(counter[counter_index], capacity)) occluded[i] |= others[i];
}
