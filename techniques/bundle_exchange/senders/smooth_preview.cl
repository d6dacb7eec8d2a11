// SPDX-License-Identifier: Apache-2.0
// What is displayed of texel sides before it has converged: smoothed as far as its error goes, by an à-trous filter
// over the cells of the atlas (Dammertz, Sewtz, Hanika, Lensch, Edge-Avoiding À-Trous Wavelet Transform for fast Global
// Illumination Filtering, HPG 2010), with weights by standard errors.
#include "bundle_exchange/base/exchange_layout.clh"
#include "lucarium/gbuffer_filter.clh"
#include "lucarium/math.clh"
#include "lucarium/surface_atlas.clh"

// What is displayed of a texel side, without its accessibility; w: 1, or 0 where it is not known.
float4 shown_light(float4 shown) { return shown.w > 0.0f ? (float4)(shown.xyz / shown.w, 1.0f) : (float4)(0.0f); }

// variance: of the luminance of shown + direct, from the batches so far (statistics as in accumulate_batch.cl); 0: not
// known; -1: no ray has come. correction: n / (n - 1) of n batches.
__kernel void begin_preview(uint sides, float correction, __global const float4* restrict shown,
                            __global const float4* restrict shown_direct, __global const float4* restrict statistics,
                            __global float4* restrict indirect, __global float4* restrict direct,
                            __global float* restrict variance) {
  const uint side = get_global_id(0);
  if (side >= sides) return;
  const float4 light = shown_light(shown[side]);
  indirect[side] = light;
  float total = correction * ratio_variance(statistics[side], luminance(light.xyz));
#ifdef BUNDLE_EXCHANGED
  direct[side] = shown_light(shown_direct[side]);
  total += correction * ratio_variance(statistics[sides + side], luminance(direct[side].xyz));
#endif
  bool known = shown[side].w > 0.0f;
#ifdef BUNDLE_EXCHANGED
  known = known || shown_direct[side].w > 0.0f;  // directions that carry emission only come first
#endif
  variance[side] = known ? total : -1.0f;
}

// The cell `step` cells away from one, where the surface goes on all the way; LUCARIUM_NONE where it does not.
uint walk_cells(AtlasInfo info, const __global uchar* links, uint cell, uint pitch, int du, int dv, uint step) {
  for (uint k = 0u; k < step; ++k) {
    if (!(links[cell] & LUCARIUM_ATLAS_LINK(du, dv))) return LUCARIUM_NONE;
    cell = (uint)((int)cell + dv * (int)pitch + du);
    if (cell >= info.cell_count) return LUCARIUM_NONE;
  }
  return cell;
}

// One level: the 3 x 3 cells that are `step` apart, by (1/4, 1/2, 1/4)² and by how likely their difference is noise.
__kernel void smooth_preview(AtlasInfo atlas_info, __global const AtlasTriangle* restrict atlas_triangles,
                             __global const uint* restrict atlas_table, __global const uchar* restrict atlas_links,
                             __global const AtlasTexel* restrict atlas_texels, uint sides, uint stride, uint slice_base,
                             __global const float4* restrict indirect, __global const float4* restrict direct,
                             __global const float* restrict variance, __global float4* restrict next_indirect,
                             __global float4* restrict next_direct, __global float* restrict next_variance) {
  const uint side = get_global_id(0) + slice_base;
  if (side >= sides) return;
  const uint doubles = atlas_info.double_sided_count, of_atlas = side % atlas_info.texel_count,
             begin = side - of_atlas;  // of all halves of its kind
  const bool front = of_atlas < doubles || of_atlas >= 2u * doubles;
  // Find the texel side's own cell, from which neighbours are counted.
  const AtlasTexel texel = atlas_texels[of_atlas];
  const AtlasTriangle triangle = atlas_triangles[texel.triangle];
  const uint home = atlas_cell(triangle, atlas_uv(triangle, texel.b1, texel.b2)),
             pitch = LUCARIUM_ATLAS_PITCH(triangle);
  const float own_variance = variance[side];
  const bool known = own_variance >= 0.0f;
  // Add the neighbours that the surface joins to the texel side, on the same side, as far as noise explains the
  // difference.
  float own = luminance(indirect[side].xyz), weight = 0.0f, squares = 0.0f;
  float3 sum = (float3)(0.0f), direct_sum = (float3)(0.0f);
#ifdef BUNDLE_EXCHANGED
  own += luminance(direct[side].xyz);
#endif
  for (int k = 0; k < 9; ++k) {
    const int du = k % 3 - 1, dv = k / 3 - 1;
    uint other = side;
    if (du != 0 || dv != 0) {
      if (pitch == 0u) continue;
      const uint cell = walk_cells(atlas_info, atlas_links, home, pitch, du, dv, stride);
      if (cell == LUCARIUM_NONE) continue;
      other = atlas_side(atlas_info, atlas_table[cell], front);
      if (other == LUCARIUM_NONE) continue;
      other += begin;
    }
    const float other_variance = variance[other];
    if (other_variance < 0.0f) continue;
    float w = atrous_weight(du, dv), value = luminance(indirect[other].xyz);
#ifdef BUNDLE_EXCHANGED
    value += luminance(direct[other].xyz);
#endif
    if (known && other != side) w *= noise_agreement(value - own, own_variance + other_variance);
    sum += w * indirect[other].xyz;
#ifdef BUNDLE_EXCHANGED
    direct_sum += w * direct[other].xyz;
#endif
    squares += w * w * other_variance;
    weight += w;
  }
  // Normalize; the variance of a weighted mean goes by squared weights.
  const float scale = weight > 0.0f ? 1.0f / weight : 0.0f, found = weight > 0.0f ? 1.0f : 0.0f;
  next_indirect[side] = (float4)(scale * sum, found);
#ifdef BUNDLE_EXCHANGED
  next_direct[side] = (float4)(scale * direct_sum, found);
#endif
  next_variance[side] = weight > 0.0f ? squares * scale * scale : -1.0f;
}
