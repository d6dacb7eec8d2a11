// SPDX-License-Identifier: Apache-2.0
#include "lucarium/surface_atlas.clh"

// One point of a triangle: barycentrics in float2 points, triangle in `triangles`.
__kernel void look_up_atlas(AtlasInfo atlas_info, __global const AtlasTriangle* restrict atlas_triangles,
                            __global const uint* restrict atlas_table, __global const uint* restrict triangles,
                            __global const float2* restrict points, uint count, __global uint* restrict fronts,
                            __global uint* restrict backs) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const uint texel = atlas_texel(atlas_triangles, atlas_table, triangles[i], points[i].x, points[i].y);
  fronts[i] = atlas_side(atlas_info, texel, true);
  backs[i] = atlas_side(atlas_info, texel, false);
}

__kernel void interpolate_atlas(AtlasInfo atlas_info, __global const AtlasTriangle* restrict atlas_triangles,
                                __global const uint* restrict atlas_table, __global const uchar* restrict atlas_links,
                                __global const float4* restrict values, __global const uint* restrict triangles,
                                __global const float2* restrict points, uint count, uint front,
                                __global float4* restrict results) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  results[i] = atlas_bilinear(atlas_info, atlas_triangles, atlas_table, atlas_links, values, triangles[i], points[i].x,
                              points[i].y, front != 0u);
}
