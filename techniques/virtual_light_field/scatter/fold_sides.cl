// SPDX-License-Identifier: Apache-2.0
// The end of a sweep at texel sides: irradiance from what has arrived, and what they send in the next sweep.
//
// Of scenes with glass texel sides have two halves (SideAccessibility); then everything that is kept of texel sides is
// there twice, first for all open halves, then for all covered ones. half_count: halves of all sides together, as many
// as there are sides or twice as many.
//
// Record of a half, two float4:
//   [0] xyz: radiance that it sends by its diffuse lobe [cd/m^2]; w: bits of its facet, LUCARIUM_NONE: none
//   [1] xyz: sum of w L; w: sum of w, over the rays of a sweep, w = dOmega a (a: accessibility of that part)
#include "lucarium/shared/surface_atlas.h"
#include "lucarium/surface_point.clh"
#include "virtual_light_field/scatter/norms.clh"

// Before the first sweep texel sides send what they emit.
__kernel void emit_sides(uint sides, uint half_count, __global const AtlasMaterial* restrict atlas_materials,
                         __global const uint* restrict side_facet, __global float4* restrict records) {
  const uint half_side = get_global_id(0), side = half_side % sides;
  if (half_side >= half_count) return;
  records[2u * half_side] = (float4)(atlas_materials[side].emission.xyz, as_float(side_facet[side]));
  records[2u * half_side + 1u] = (float4)(0.0f);
}

// Irradiance over pi, e = sum w L / sum w (a ratio, exact in a uniform field whatever the rays), of sweep `sweep`; in
// the first one that of light samples, unless all light is exchanged. Work-item: FIELD_NORM_CHUNK halves. albedo: per
// texel side, xyz of what it reflects diffusely. shares: of the side's area. direct, indirect: xyz the direct e, then
// the sum over later sweeps. last: xyz e of this sweep, w: sum of w [sr]. exchanged: 1: emitters or a sky send light.
__kernel void fold_sides(uint sides, uint half_count, uint sweep, uint sampled, uint exchanged,
                         __global const float4* restrict albedo, __global const AtlasTexel* restrict atlas_texels,
                         __global const float* restrict shares, __global const float4* restrict light_samples,
                         __global float4* restrict records, __global float4* restrict direct,
                         __global float4* restrict indirect, __global float4* restrict last,
                         __global float4* restrict norms) {
  const uint chunk = get_global_id(0), first = chunk * FIELD_NORM_CHUNK;
  if (first >= half_count) return;
  float4 sums[FIELD_NORMS];
  for (uint k = 0u; k < FIELD_NORMS; ++k) sums[k] = (float4)(0.0f);
  for (uint i = first; i < min(first + FIELD_NORM_CHUNK, half_count); ++i) {
    const uint side = i % sides;
    const float4 received = records[2u * i + 1u];
    float4 e = received.w > 0.0f ? (float4)(received.xyz / received.w, 1.0f) : (float4)(0.0f);
    if (sweep == 0u) {
      // A small half may have no sample. It has the other's, unless it has exchanged light: samples stop at glass, and
      // what later sweeps bring to this half is what is missing in its own direct light, not in the other's.
      float4 samples = light_samples[i];
      const bool borrows = !(samples.w > 0.0f) && half_count > sides;
      if (borrows) samples = light_samples[i < sides ? i + sides : side];
      const float4 lit = samples.w > 0.0f ? (float4)(samples.xyz * (M_1_PI_F / samples.w), 1.0f) : (float4)(0.0f);
      // Punctual lights are always sampled; emitters and the sky too where `sampled`.
      if (!sampled)
        e = (float4)(e.xyz + lit.xyz, fmax(e.w, lit.w));
      else if (!borrows || !exchanged || !(e.w > 0.0f))
        e = lit;
      direct[i] = e;
      indirect[i] = (float4)(0.0f);
    } else {
      indirect[i] = (float4)(indirect[i].xyz + e.xyz, fmax(indirect[i].w, e.w));
    }
    last[i] = (float4)(e.xyz, received.w);
    const float4 sent = records[2u * i];
    const float3 now = albedo[side].xyz * e.xyz, before = sent.xyz;
    const float measure = M_PI_F * atlas_texels[side].area * shares[i];
    add_norms(sums, measure, now, before, albedo[side].xyz * (direct[i].xyz + indirect[i].xyz));
    records[2u * i] = (float4)(now, sent.w);
    records[2u * i + 1u] = (float4)(0.0f);
  }
  for (uint k = 0u; k < FIELD_NORMS; ++k) norms[(size_t)chunk * FIELD_NORMS + k] = sums[k];
}

// Sums of partial sums, in order. Work-item k: the k-th of FIELD_NORMS.
__kernel void sum_norms(uint chunks, __global const float4* restrict partial, __global float4* restrict norms) {
  const uint k = get_global_id(0);
  if (k >= FIELD_NORMS) return;
  float4 sum = (float4)(0.0f), lost = sum;
  for (uint chunk = 0u; chunk < chunks; ++chunk) {
    const float4 next = partial[(size_t)chunk * FIELD_NORMS + k] - lost, grown = sum + next;
    lost = (grown - sum) - next;
    sum = grown;
  }
  norms[k] = sum;
}

// What is displayed, times what it counts in interpolation (accessibility): w. tail: of the last sweep, per channel.
// held: all light, for rays of pixels, which scatter it once more: with `hold` without that of the last sweep.
__kernel void show_sides(uint half_count, float4 tail, uint hold, __global const float* restrict shares,
                         __global const float4* restrict direct, __global const float4* restrict indirect,
                         __global const float4* restrict last, __global float4* restrict shown_direct,
                         __global float4* restrict shown, __global float4* restrict held) {
  const uint i = get_global_id(0);
  if (i >= half_count) return;
  const float share = shares[i];
  shown_direct[i] = (direct[i].w > 0.0f ? share : 0.0f) * (float4)(direct[i].xyz, 1.0f);
  const float3 total = indirect[i].xyz + tail.xyz * last[i].xyz;
  shown[i] = (indirect[i].w > 0.0f ? share : 0.0f) * (float4)(total, 1.0f);
  const float3 all = direct[i].xyz + total - (hold ? last[i].xyz : (float3)(0.0f));
  held[i] = (fmax(direct[i].w, indirect[i].w) > 0.0f ? share : 0.0f) * (float4)(fmax(all, 0.0f), 1.0f);
}
