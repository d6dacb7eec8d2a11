// SPDX-License-Identifier: Apache-2.0
// Counts what a sample has taken, for counters and limitations: rays, choices of virtual lights, and how paths ended.
#include "bidirectional_vpl/eye/eye_path.clh"

void add_count(__global uint* counts, uint index, uint count) {
  if (count) atomic_add(counts + index, count);
}

// Paths with light that is NaN, infinite or negative, and those that a limit has ended.
__kernel void count_path_ends(__global const EyePathState* restrict states, uint pixels, uint chunk,
                              __global uint* restrict counts) {
  const uint first = (uint)get_global_id(0) * chunk;
  if (first >= pixels) return;
  uint bad = 0u, capped = 0u, mirrors = 0u;
  for (uint i = first; i < min(first + chunk, pixels); ++i) {
    bad += (states[i].flags & EYE_PATH_BAD) != 0u;
    capped += (states[i].flags & EYE_PATH_CAPPED) != 0u;
    mirrors += (states[i].flags & EYE_PATH_MIRRORS) != 0u;
  }
  add_count(counts, BIDIRECTIONAL_COUNT_BAD, bad);
  add_count(counts, BIDIRECTIONAL_COUNT_CAPPED, capped);
  add_count(counts, BIDIRECTIONAL_COUNT_MIRRORS, mirrors);
}

// Rays of a bounce, and with `choices` also the vertices at which a virtual light was to be chosen, of the active
// paths.
__kernel void count_shadow_rays(__global const uint* restrict active, __global const Ray* restrict rays,
                                __global const float4* restrict light, uint index, uint choices, uint chunk,
                                __global uint* restrict counts) {
  const uint first = (uint)get_global_id(0) * chunk;
  if (first >= active[0]) return;
  uint traced = 0u, chosen = 0u;
  const uint end = min(first + chunk, active[0]);
  for (uint i = first; i < end; ++i) traced += ray_is_active(rays[i]);
  for (uint i = first; i < (choices ? end : first); ++i) chosen += as_uint(light[i].w) != LUCARIUM_NONE;
  add_count(counts, index, traced);
  if (choices) add_count(counts, BIDIRECTIONAL_COUNT_CHOICES, chosen);
}
