// SPDX-License-Identifier: Apache-2.0
// Moves the paths that go on to the front of the queue, in their order.
#include "lucarium/ray_ends.clh"

// One work-item per path of the bounce that has ended (the schedule's size); survivors has next_active[0] entries.
__kernel void advance_paths(__global const uint* restrict survivors, __global const uint* restrict next_active,
                            __global const Ray* restrict next_rays, __global const uint* restrict next_queue,
                            LUCARIUM_CONST_RAY_ENDS_PARAMETER(next_ends) LUCARIUM_RAY_ENDS_PARAMETER(ends)
                                __global Ray* restrict rays,
                            __global uint* restrict queue, __global uint* restrict active) {
  const uint i = get_global_id(0);
  const uint count = next_active[0];
  if (i == 0) active[0] = count;
  if (i >= count) return;
  rays[i] = next_rays[survivors[i]];
  LUCARIUM_STORE_RAY_ENDS(ends, i, next_ends[survivors[i]]);
  queue[i] = next_queue[survivors[i]];
}
