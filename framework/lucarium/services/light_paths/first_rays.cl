// SPDX-License-Identifier: Apache-2.0
// The first rays of light paths in the order of their keys (first_ray_keys.clh), and back.
#include "lucarium/shared/ray.h"

__kernel void order_first_rays(__global const uint* restrict order, uint count, __global const Ray* restrict rays,
                               __global Ray* restrict ordered, uint slice_base) {
  const uint i = slice_base + (uint)get_global_id(0);
  if (i < count) ordered[i] = rays[order[i]];
}

// What the ordered rays have met, as paths are numbered.
__kernel void return_first_hits(__global const uint* restrict order, uint count, __global const Hit* restrict ordered,
                                __global Hit* restrict hits, uint slice_base) {
  const uint i = slice_base + (uint)get_global_id(0);
  if (i < count) hits[order[i]] = ordered[i];
}
