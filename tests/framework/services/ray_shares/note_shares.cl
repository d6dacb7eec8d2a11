// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/ray_shares/ray_shares.clh"

// How often each ray is traced, and by which work-item last.
__kernel void note_shares(__global uint* restrict times, __global uint* restrict items, RAY_SHARE_PARAMETERS) {
  RAY_SHARE(share);
  for (uint i = share.first; i < share.end; ++i) {
    atomic_inc(times + i);
    items[i] = (uint)get_global_id(0) + slice_base;
  }
}
