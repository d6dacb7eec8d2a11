// SPDX-License-Identifier: Apache-2.0
// Look-ups in a stored bundle one by one.
#include "bidirectional_vpl/bundles/look_up_bundle.cl"

__kernel void look_up_one(LUCARIUM_SCENE_PARAMETERS uint count, __global const LayeredView* restrict views,
                          __global const uint* restrict pixel_start, __global const LayeredFragment* restrict fragments,
                          __global const Ray* restrict rays, __global const uint* restrict left,
                          __global Hit* restrict hits) {
  const uint i = (uint)get_global_id(0);
  if (i >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  const FragmentList list = {views, pixel_start, fragments};
  hits[i] = look_up(&scene, &list, rays[i], left[i]);
}
