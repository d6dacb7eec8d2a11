// SPDX-License-Identifier: Apache-2.0
// What the means need of the atlas.
#include "lucarium/shared/surface_atlas.h"

// Diffuse albedo and emission of texel sides, of each of their halves; w: area times accessibility [m^2].
__kernel void copy_materials(uint half_count, AtlasInfo atlas_info, __global const AtlasTexel* restrict atlas_texels,
                             __global const AtlasMaterial* restrict atlas_materials,
                             __global const float* restrict accessibility, __global float4* restrict albedo,
                             __global float4* restrict emission) {
  const uint i = get_global_id(0), side = i % atlas_info.texel_count;
  if (i >= half_count) return;
  const float area = atlas_texels[side].area * accessibility[i];
  albedo[i] = (float4)(atlas_materials[side].diffuse.xyz, area);
  emission[i] = (float4)(atlas_materials[side].emission.xyz, area);
}
