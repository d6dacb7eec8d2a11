// SPDX-License-Identifier: Apache-2.0
// What the means need of the atlas.
#include "lucarium/shared/surface_atlas.h"

// Diffuse albedo and emission of texel sides; w: area times accessibility [m^2].
__kernel void copy_materials(uint sides, __global const AtlasTexel* restrict atlas_texels,
                             __global const AtlasMaterial* restrict atlas_materials,
                             __global const float* restrict accessibility, __global float4* restrict albedo,
                             __global float4* restrict emission) {
  const uint side = get_global_id(0);
  if (side >= sides) return;
  const float area = atlas_texels[side].area * accessibility[side];
  albedo[side] = (float4)(atlas_materials[side].diffuse.xyz, area);
  emission[side] = (float4)(atlas_materials[side].emission.xyz, area);
}
