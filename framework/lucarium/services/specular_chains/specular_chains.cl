// SPDX-License-Identifier: Apache-2.0
#include "lucarium/ray_ends.clh"

// The survivors become the queue. counts: chains that took part in the segment, and that go on.
__kernel void advance_queue(__global const uint* restrict survivors, __global const uint* restrict next_active,
                            __global const Ray* restrict next_rays, __global const uint* restrict next_queue,
                            LUCARIUM_CONST_RAY_ENDS_PARAMETER(next_ends) LUCARIUM_RAY_ENDS_PARAMETER(ends)
                                __global Ray* restrict rays,
                            __global uint* restrict queue, __global uint* restrict active,
                            __global uint* restrict counts) {
  const uint i = get_global_id(0);
  const uint count = next_active[0];
  if (i == 0u) {
    counts[0] = active[0];
    counts[1] = count;
    active[0] = count;
  }
  if (i >= count) return;
  rays[i] = next_rays[survivors[i]];
  LUCARIUM_STORE_RAY_ENDS(ends, i, next_ends[survivors[i]]);
  queue[i] = next_queue[survivors[i]];
}
