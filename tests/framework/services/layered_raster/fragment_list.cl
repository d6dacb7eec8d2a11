// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/layered_raster/fragment_list.clh"

// Point i: position; normal, w: 1 on the front; its triangle. seen: triangle (LUCARIUM_NONE: nothing), whether the
// point was found, and bits of the barycentric weights there.
__kernel void look_up(LUCARIUM_SCENE_PARAMETERS __global const float4* positions, __global const float4* normals,
                      __global const uint* triangles, uint count, uint around, __global const LayeredView* views,
                      __global const uint* pixel_start, __global const LayeredFragment* fragments,
                      __global uint4* seen) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  const FragmentList list = {views, pixel_start, fragments};
  const ListedPoint point = listed_point(&list, positions[i].xyz, triangles[i], normals[i].xyz, normals[i].w > 0.0f);
  const SeenFragment result = seen_fragment(&list, &point, around);
  seen[i] = (uint4)(LUCARIUM_NONE, result.found, 0u, 0u);
  if (result.fragment == LUCARIUM_NONE) return;
  const uint triangle = fragments[result.fragment].triangle & ~LAYERED_AWAY;
  const float2 b = fragment_weights(&scene, &list, triangle, result.centre);
  seen[i] = (uint4)(triangle, result.found, as_uint(b.x), as_uint(b.y));
}
