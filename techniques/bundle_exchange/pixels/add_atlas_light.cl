// SPDX-License-Identifier: Apache-2.0
// Light towards the eye that the atlas knows: what the G-buffer's points reflect of it.
#include "bundle_exchange/pixels/looked_up_light.clh"
#include "lucarium/services/layer_sums/layer_sums.clh"

// What the atlas knows of a sample. That changes from iteration to iteration, so that the sample counts
// `atlas_weight` of the mean (later ones count more).
// shown, shown_direct (BUNDLE_EXCHANGED): irradiance over pi of texel sides times w, their accessibility, or 0 where it
// is not known. gathered: light of chains that begin at the pixels, scattered once and more often; they bring all there
// is where they are `whole`. bundled: the same, sums over the directions whose number is in w. exchanged: direct light
// that bundles have carried. deviations, where a picture `deviates`: += how far this sample lies from the mean of the
// `samples` before.
__kernel void add_atlas_light(AtlasInfo atlas_info, __global const AtlasTriangle* restrict atlas_triangles,
                              __global const uint* restrict atlas_table, __global const uchar* restrict atlas_links,
                              SIDE_HALVES_PARAMETERS __global const GBufferPoint* restrict points, uint count,
                              float atlas_weight, uint samples, uint deviates, uint whole,
                              __global const float4* restrict shown, __global const float4* restrict shown_direct,
                              __global const float4* restrict bundled, __global const float4* restrict gathered,
                              __global float4* restrict exchanged, __global float4* restrict indirect,
                              __global float* restrict deviations) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const GBufferPoint point = points[i];
  // Add what the pixel has gathered: by rays, and as a mean over directions by bundles.
  float3 once = gathered[2u * i].xyz, reflected = gathered[2u * i + 1u].xyz;
  const float directions = bundled[2u * i].w;
  if (directions > 0.0f) {
    once += bundled[2u * i].xyz / directions;
    reflected += bundled[2u * i + 1u].xyz / directions;
  }
  if (!whole && point.state == LUCARIUM_GBUFFER_SURFACE)
    add_looked_up(atlas_info, atlas_triangles, atlas_table, atlas_links, half_count, covered, &point, shown,
                  shown_direct, &once, &reflected);
  if (deviates) deviations[i] += sample_deviation(once + reflected, exchanged[i].xyz + indirect[i].xyz, (float)samples);
  exchanged[i] = mix_sample(exchanged[i], once, atlas_weight);
  indirect[i] = mix_sample(indirect[i], reflected, atlas_weight);
}
