// SPDX-License-Identifier: Apache-2.0
// Which texel a pixel shows, for looking at the atlas.
#include "lucarium/random.clh"
#include "lucarium/shared/gbuffer.h"
#include "lucarium/surface_atlas.clh"

// A colour per texel side, none of them dark; black where there is none.
float4 side_color(uint side) {
  if (side == LUCARIUM_NONE) return (float4)(0.0f);
  const uint hash = hash_uint2(side, 0x61746c73u);
  const float3 value = convert_float3((uint3)(hash, hash >> 8, hash >> 16) & 255u) / 255.0f;
  return (float4)(0.05f + 0.9f * value * value, 1.0f);
}

__kernel void draw_atlas_layer(AtlasInfo atlas_info, __global const AtlasTriangle* restrict atlas_triangles,
                               __global const uint* restrict atlas_table, __global const GBufferPoint* restrict points,
                               uint count, __global float4* restrict colors) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  colors[i] = (float4)(0.0f);
  const GBufferPoint point = points[i];
  if (point.state != LUCARIUM_GBUFFER_SURFACE) return;
  const uint texel = atlas_texel(atlas_triangles, atlas_table, point.triangle, point.u, point.v);
  colors[i] = side_color(atlas_side(atlas_info, texel, point.normal.w == 0.0f));
}

// The colour of every texel side, for pictures of the atlas itself.
__kernel void color_atlas_sides(uint count, __global float4* restrict colors) {
  const uint side = get_global_id(0);
  if (side < count) colors[side] = side_color(side);
}
