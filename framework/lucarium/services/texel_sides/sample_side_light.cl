// SPDX-License-Identifier: Apache-2.0
// Direct irradiance of texel sides by light samples, a run of texel sides at a time: the direct light that comes from
// another method than the bundles (Hermes et al. 2010, section 6.5; there shadow maps).
#include "lucarium/atlas_surface.clh"
#include "lucarium/scene.clh"
#include "lucarium/services/texel_sides/side_points.clh"

#define LIGHT_POINT_PARAMETERS                                                    \
  const AtlasInfo atlas_info, __global const AtlasSample *restrict atlas_samples, \
      __global const uint *restrict levels, const uint first, const uint sides, const uint round_index,
#define LIGHT_POINT_ARGUMENTS atlas_info, atlas_samples, levels, first, sides, round_index,
#define LIGHT_SUM_PARAMETERS __global float4 *restrict sums,
#define LIGHT_SUM_ARGUMENTS sums,
#define LIGHT_POINT_STREAM 0x64697265u
#include "lucarium/services/light_at_points/light_at_points.clh"

// Every round takes another of a texel side's points, of those that are open, lit by the cosine to the geometric
// normal. levels: SideAccessibility::points(); sides: their number, of which a run begins with
// `first`.
bool light_point(const Scene* scene, uint i, LIGHT_POINT_PARAMETERS Surface* surface) {
  const uint side = first + i;
  if (side >= sides) return false;
  const AtlasSample sample = atlas_samples[(size_t)side * SIDE_POINTS + side_point(levels[side], round_index)];
  *surface = atlas_surface(scene, atlas_info, side, sample.triangle, sample.b1, sample.b2);
  surface->n_s = surface->n_g;
  return true;
}

void add_light(const Scene* scene, uint i, float3 light, float3 direction, float random,
               LIGHT_SUM_PARAMETERS uint samples) {
  const float4 before = samples ? (float4)(0.0f) : sums[i];
  sums[i] = before + (float4)(light, (float)samples);
}

// Each counts by the accessibility of its point, in the half that the point belongs to: those of covered halves begin
// at `sides`.
__kernel void scatter_samples(uint first, uint count, uint sides, uint round_index,
                              __global const uint* restrict levels, __global const float4* restrict samples,
                              __global float4* restrict light_samples) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const uint side = first + i, level = levels[side], point = side_point(level, round_index);
  light_samples[point_covered(level, point) ? sides + side : side] += point_weight(level, point) * samples[i];
}
