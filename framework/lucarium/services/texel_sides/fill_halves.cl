// SPDX-License-Identifier: Apache-2.0
// Direct light of halves of texel sides (SideAccessibility) in which no light sample is taken (sample_side_light.cl).
#include "lucarium/atlas_surface.clh"
#include "lucarium/services/texel_sides/side_parts.clh"
#include "lucarium/services/texel_sides/side_points.clh"
#include "lucarium/surface_atlas.clh"

// Whether any part of the side belongs to the half.
bool half_has_part(const __global uint* covered, uint side, bool half_covered) {
  const uint none = half_covered ? 0u : ~0u;
  for (uint word = 0u; word < SIDE_COVER_WORDS; ++word)
    if (covered[(size_t)side * SIDE_COVER_WORDS + word] != none) return true;
  return false;
}

// Small halves may hold no point. They have the light of the same half of texel sides beside them; where these have
// none either, open ones that of their own side's other half. Covered ones have no direct light then: samples end at
// glass, and what comes through it arrives along bundles.
__kernel void fill_halves(AtlasInfo atlas_info, __global const AtlasTriangle* restrict atlas_triangles,
                          __global const uint* restrict atlas_table, __global const uchar* restrict atlas_links,
                          __global const AtlasTexel* restrict atlas_texels, uint first, uint count, uint sides,
                          __global const uint* restrict levels, __global const uint* restrict covered,
                          __global float4* restrict light_samples) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const uint side = first + i;
  for (uint half_covered = 0u; half_covered < 2u; ++half_covered) {
    if (half_has_point(levels[side], half_covered) || !half_has_part(covered, side, half_covered)) continue;
    const uint begin = half_covered ? sides : 0u;
    // Sum over the cells that the surface joins to the side's own.
    float4 sum = (float4)(0.0f);
    const AtlasTexel texel = atlas_texels[side];
    const AtlasTriangle triangle = atlas_triangles[texel.triangle];
    const int home = (int)atlas_cell(triangle, atlas_uv(triangle, texel.b1, texel.b2)),
              pitch = (int)LUCARIUM_ATLAS_PITCH(triangle);
    const uint links = pitch == 0 ? 0u : atlas_links[home];
    for (int k = 0; k < 9; ++k) {
      const int du = k % 3 - 1, dv = k / 3 - 1;
      if ((du == 0 && dv == 0) || !(links & LUCARIUM_ATLAS_LINK(du, dv))) continue;
      const uint other =
          atlas_side(atlas_info, atlas_table[home + dv * pitch + du], atlas_side_is_front(atlas_info, side));
      if (other != LUCARIUM_NONE && levels[other] != 0u && half_has_point(levels[other], half_covered))
        sum += light_samples[begin + other];
    }
    const float4 none = half_covered ? (float4)(0.0f, 0.0f, 0.0f, 1.0f) : light_samples[sides + side];
    light_samples[begin + side] = sum.w > 0.0f ? sum : none;
  }
}
