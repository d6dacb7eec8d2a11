// SPDX-License-Identifier: Apache-2.0
// Photons sorted by the cells of a grid.
#include "lucarium/math.clh"
#include "lucarium/services/light_at_points/photon_cells.clh"
#include "lucarium/shared/light_path.h"

// keys: bucket of photon i, mask + 1 for one that is none.
__kernel void photon_keys(__global const VirtualLight* restrict photons, uint count, float cell, uint mask,
                          __global uint* restrict keys, __global uint* restrict values) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  values[i] = i;
  keys[i] =
      !is_black(photons[i].flux.xyz) ? photon_bucket(photon_cell(photons[i].position.xyz, cell), mask) : mask + 1u;
}

// starts[b]: first of the sorted photons whose bucket is b or higher, for b <= mask + 1.
__kernel void photon_bucket_starts(__global const uint* restrict keys, uint count, uint mask,
                                   __global uint* restrict starts) {
  const uint i = get_global_id(0);
  if (i > count) return;
  const uint from = i == 0u ? 0u : keys[i - 1u] + 1u, to = i == count ? mask + 1u : keys[i];
  for (uint b = from; b <= to; ++b) starts[b] = i;
}
