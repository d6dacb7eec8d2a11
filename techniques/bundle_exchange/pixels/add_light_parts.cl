// SPDX-License-Identifier: Apache-2.0
// What each part of the technique brings to a sample of the image (DebugLayers).
#include "bundle_exchange/base/exchange_layout.clh"
#include "bundle_exchange/pixels/looked_up_light.clh"
#include "lucarium/services/layer_sums/layer_sums.clh"

// The light of add_atlas_light(), part by part, with the same arguments and the same weight of the sample.
__kernel void add_light_parts(AtlasInfo atlas_info, __global const AtlasTriangle* restrict atlas_triangles,
                              __global const uint* restrict atlas_table, __global const uchar* restrict atlas_links,
                              SIDE_HALVES_PARAMETERS __global const GBufferPoint* restrict points, uint count,
                              float atlas_weight, uint whole, __global const float4* restrict shown,
                              __global const float4* restrict shown_direct, __global const float4* restrict bundled,
                              __global const float4* restrict gathered, __global float4* restrict exchanged_direct,
                              __global float4* restrict diffuse_exchange, __global float4* restrict specular_chains,
                              __global float4* restrict bundle_gather) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const GBufferPoint point = points[i];
  float3 once = (float3)(0.0f), reflected = (float3)(0.0f), by_bundles = (float3)(0.0f);
  if (!whole && point.state == LUCARIUM_GBUFFER_SURFACE)
    add_looked_up(atlas_info, atlas_triangles, atlas_table, atlas_links, half_count, covered, &point, shown,
                  shown_direct, &once, &reflected);
  const float directions = bundled[2u * i].w;
  if (directions > 0.0f) by_bundles = (bundled[2u * i].xyz + bundled[2u * i + 1u].xyz) / directions;
  exchanged_direct[i] = mix_sample(exchanged_direct[i], once, atlas_weight);
  diffuse_exchange[i] = mix_sample(diffuse_exchange[i], reflected, atlas_weight);
  specular_chains[i] = mix_sample(specular_chains[i], gathered[2u * i].xyz + gathered[2u * i + 1u].xyz, atlas_weight);
  bundle_gather[i] = mix_sample(bundle_gather[i], by_bundles, atlas_weight);
}

// What the texel side behind a pixel holds and sends (SideState), as colours.
__kernel void add_side_state(AtlasInfo atlas_info, __global const AtlasTriangle* restrict atlas_triangles,
                             __global const uint* restrict atlas_table,
                             SIDE_HALVES_PARAMETERS __global const GBufferPoint* restrict points, uint count,
                             float atlas_weight, __global const float* restrict shares,
                             __global const float4* restrict balances, __global const float4* restrict histories,
                             __global float4* restrict accessibility, __global float4* restrict balance,
                             __global float4* restrict direction_history) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const GBufferPoint point = points[i];
  float3 accessible = (float3)(0.0f), scaled = accessible, remembered = accessible;
  uint side = LUCARIUM_NONE;
  if (point.state == LUCARIUM_GBUFFER_SURFACE)
    side = atlas_side(atlas_info, atlas_texel(atlas_triangles, atlas_table, point.triangle, point.u, point.v),
                      point.normal.w == 0.0f);
  if (side != LUCARIUM_NONE) {
    accessible =
        (float3)(shares[side] + (half_count > atlas_info.texel_count ? shares[atlas_info.texel_count + side] : 0.0f));
    const uint own =
        side + half_at(atlas_info, half_count, covered, atlas_triangles + point.triangle, side, point.u, point.v);
    scaled = balances[own].xyz;
    remembered = histories[own].xyz;
  }
  accessibility[i] = mix_sample(accessibility[i], accessible, atlas_weight);
  balance[i] = mix_sample(balance[i], scaled, atlas_weight);
  direction_history[i] = mix_sample(direction_history[i], remembered, atlas_weight);
}
