// SPDX-License-Identifier: Apache-2.0
// Keeping a stored bundle for later depths of camera paths (Tokuyoshi and Ogaki 2012, section 7: reuse for
// multi-bounce).
#include "lucarium/shared/layered_raster.h"

// Copies the bundle's starts of pixels to entry `slot`, and its fragments to `first` and on, where both fit. Any
// number of work-items.
__kernel void keep_bundle(uint pixels, uint entries, uint capacity, uint slot, uint first,
                          __global const uint* restrict pixel_start, __global const LayeredFragment* restrict fragments,
                          __global uint* restrict kept_starts, __global LayeredFragment* restrict kept_fragments) {
  const uint total = pixel_start[pixels];
  if (slot >= entries || total > capacity - first) return;
  const uint item = (uint)get_global_id(0), items = (uint)get_global_size(0);
  __global uint* starts = kept_starts + (size_t)slot * (pixels + 1u);
  for (uint i = item; i <= pixels; i += items) starts[i] = pixel_start[i];
  for (uint i = item; i < total; i += items) kept_fragments[first + i] = fragments[i];
}
