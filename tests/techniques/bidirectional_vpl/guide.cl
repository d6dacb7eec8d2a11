// SPDX-License-Identifier: Apache-2.0
// Directions of a guide, and their density.
#include "bidirectional_vpl/guide/guide.clh"
#include "lucarium/random.clh"

Bsdf bsdf_facing(float3 n_g, float3 n_s) {
  Bsdf bsdf;
  bsdf.n_g = n_g;
  bsdf.n_s = n_s;
  return bsdf;
}

// directions[i]: xyz sampled by photons of the mask; w: 1 where guides reach it.
__kernel void sample_guides(uint count, __global const GuidePhoton* restrict photons, uint mask, float4 n_g, float4 n_s,
                            __global float4* restrict directions) {
  const uint i = (uint)get_global_id(0);
  if (i >= count) return;
  const Guide guide = {photons, 0u, mask};
  const Bsdf bsdf = bsdf_facing(n_g.xyz, n_s.xyz);
  const float4 u = random_float4(1u, i, 0u);
  const float3 direction = sample_guide(&guide, u.y, u.zw);
  directions[i] = (float4)(direction, guide_reaches(&bsdf, direction) ? 1.0f : 0.0f);
}

// densities[i] of directions[i].
__kernel void weigh_guides(uint count, __global const GuidePhoton* restrict photons, uint mask, float4 n_g, float4 n_s,
                           __global const float4* restrict directions, __global float* restrict densities) {
  const uint i = (uint)get_global_id(0);
  if (i >= count) return;
  const Guide guide = {photons, 0u, mask};
  const Bsdf bsdf = bsdf_facing(n_g.xyz, n_s.xyz);
  densities[i] = guide_pdf(&guide, &bsdf, directions[i].xyz);
}
