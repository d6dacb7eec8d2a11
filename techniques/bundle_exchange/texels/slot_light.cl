// SPDX-License-Identifier: Apache-2.0
// Direct irradiance of slots by light samples, a run of slots at a time: the direct light that comes from another
// method than the bundles (Hermes et al. 2010, section 6.5; there shadow maps).
#include "bundle_exchange/texels/slot_points.clh"
#include "lucarium/atlas_surface.clh"
#include "lucarium/scene.clh"

#define LIGHT_POINT_PARAMETERS                                                    \
  const AtlasInfo atlas_info, __global const AtlasSample *restrict atlas_samples, \
      __global const uint *restrict levels, const uint first, const uint slots, const uint turn,
#define LIGHT_POINT_ARGUMENTS atlas_info, atlas_samples, levels, first, slots, turn,
#define LIGHT_SUM_PARAMETERS __global float4 *restrict sums,
#define LIGHT_SUM_ARGUMENTS sums,
#define LIGHT_POINT_STREAM 0x64697265u
#include "lucarium/services/light_at_points/light_at_points.clh"

// Every round takes another of a slot's points, of those that are open, lit by the cosine to the geometric normal.
// levels: SlotOpenness::points(); slots: that there are, of which a run begins with `first`.
bool light_point(const Scene* scene, uint i, LIGHT_POINT_PARAMETERS Surface* surface) {
  const uint slot = first + i;
  if (slot >= slots) return false;
  const AtlasSample sample = atlas_samples[(size_t)slot * SLOT_POINTS + slot_point(levels[slot], turn)];
  *surface = atlas_surface(scene, atlas_info, slot, sample.triangle, sample.b1, sample.b2);
  surface->n_s = surface->n_g;
  return true;
}

void add_light(const Scene* scene, uint i, float3 light, float3 direction, float random,
               LIGHT_SUM_PARAMETERS uint samples) {
  const float4 before = samples ? (float4)(0.0f) : sums[i];
  sums[i] = before + (float4)(light, (float)samples);
}

// Each counts by the openness of its point.
__kernel void scatter_samples(uint first, uint count, uint turn, __global const uint* restrict levels,
                              __global const float4* restrict samples, __global float4* restrict light_samples) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const uint slot = first + i, level = levels[slot];
  light_samples[slot] += point_weight(level, slot_point(level, turn)) * samples[i];
}
