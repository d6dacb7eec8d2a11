// SPDX-License-Identifier: Apache-2.0
// Glossy interreflections (Hermes et al. 2010, section 5.4), second half: texel sides send towards the next direction
// what their specular lobe reflects of what the last ones brought (receive_history.cl). The transfer atlas of the paper
// stores L_x f_r(y, ω_i, ω_{i+1}) cosθ (equation 4) of the one direction before; a window of more of them varies less.
#include "bundle_exchange/base/exchange_layout.clh"
#include "bundle_exchange/shared/history_step.h"
#include "lucarium/bsdf.clh"
#include "lucarium/shared/surface_atlas.h"
#include "lucarium/shared/surface_point.h"

// The reflection lobe of a texel side seen from `view`, by what the atlas keeps of its material.
Bsdf side_reflection(const __global AtlasMaterial* material, float3 n_g, float3 view) {
  Bsdf bsdf;
  bsdf.n_g = n_g;
  bsdf.n_s = material->shading.xyz;
  bsdf.view = view;
  bsdf.diffuse = bsdf.transmission = (float3)(0.0f);
  bsdf.f0 = material->f0.xyz;
  bsdf.f90 = material->f0.w;
  bsdf.dielectric_f0 = bsdf.dielectric_f90 = 0.0f;
  bsdf.eta = 1.0f;
  bsdf.alpha = material->diffuse.w;
  bsdf.p_reflect = dot(bsdf.n_s, view) > 0.0f ? 1.0f : 0.0f;
  bsdf.p_diffuse = bsdf.p_transmit = 0.0f;
  bsdf.flags = 0u;
  return bsdf;
}

float3 reflection_albedo(const __global float* table, const Bsdf* bsdf) {
  const float2 e = specular_albedo_directional(table, dot(bsdf->n_s, bsdf->view), sqrt(bsdf->alpha));
  return bsdf->f0 * (e.x - e.y) + bsdf->f90 * e.y;
}

// Work-item i: adds to what entry i sends towards `omega` the light that it reflects of the last history_step.reflected
// directions: equation 4, evaluated when `omega` = ω_{i+1} has come and not in advance, so that one record serves all
// later ones. With f the specular lobe, ρ its albedo, L and w of the rays that came from those directions (their cosine
// is implicit), and A the texel side's area times accessibility:
//   by their share:  ρ Σ f w L / Σ f w        by themselves:  Σ f w L / (history_step.reflected A)
// list: texel sides, or halves of them. albedo: w is A. diffuse: what the texel side sends otherwise; not read where
// history_step.adds says that the record holds it.
__kernel void send_history(__global const float* restrict scene_albedo_table,
                           __global const AtlasTexel* restrict atlas_texels,
                           __global const SurfacePoint* restrict atlas_points,
                           __global const AtlasMaterial* restrict atlas_materials, AtlasInfo atlas_info, uint count,
                           HistoryStep history_step, float4 omega, __global const float4* restrict directions,
                           __global const uint* restrict list, __global const float4* restrict history,
                           __global const float4* restrict diffuse, __global const float4* restrict albedo,
                           __global float4* restrict records) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const uint own = list[i], side = own % atlas_info.texel_count;
  const float3 n_g = atlas_points[side].normal.xyz;
  const float3 out = dot(n_g, omega.xyz) > 0.0f ? omega.xyz : -omega.xyz;
  const Bsdf bsdf = side_reflection(atlas_materials + side, n_g, out);
  float3 light[BUNDLE_REFLECTED > 0 ? BUNDLE_REFLECTED : 1], share = (float3)(0.0f);
  for (uint k = 0u; k < BUNDLE_REFLECTED; ++k) light[k] = (float3)(0.0f);
  // Add what each remembered direction brought, latest first.
  for (uint m = 0u; m < history_step.reflected; ++m) {
    const uint index = (history_step.index + history_step.length - 1u - m) % history_step.length;
    const float3 axis = directions[index].xyz, in = dot(n_g, axis) > 0.0f ? axis : -axis;
    const float cosine = dot(bsdf.n_s, in);
    if (!(cosine > 1e-6f)) continue;
    // Take the cosine out: rays hit a texel side in proportion to it already.
    const float3 f = eval_bsdf(&bsdf, in) / cosine;
    const __global float4* received = history + (size_t)index * BUNDLE_REFLECTED * count + i;
    for (uint k = 0u; k < BUNDLE_REFLECTED; ++k) light[k] += f * received[(size_t)k * count].xyz;
    share += f * received[0].w;
  }
  // Normalize the sum: by the rays expected, or by the lobe's share of those that came, which varies less.
  const float measure =
      (float)history_step.reflected * albedo[own].w / (history_step.by_area ? 1.0f : atlas_texels[side].area);
  float3 scale = (float3)(measure > 0.0f ? 1.0f / measure : 0.0f);
  if (history_step.by_share) {
    const float3 albedo = bsdf.p_reflect > 0.0f ? reflection_albedo(scene_albedo_table, &bsdf) : (float3)(0.0f);
    scale = select((float3)(0.0f), albedo / share, share > 0.0f);
  }
  for (uint k = 0u; k < BUNDLE_REFLECTED; ++k) {
    __global float4* send = records + (size_t)own * BUNDLE_RECORD + 2u * (BUNDLE_FIRST + k);
    const float3 otherwise = history_step.adds ? (*send).xyz : diffuse[(size_t)own * BUNDLE_REFLECTED + k].xyz;
    (*send).xyz = otherwise + scale * light[k];
  }
}
