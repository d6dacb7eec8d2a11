// SPDX-License-Identifier: Apache-2.0
// Direct irradiance of slots by light samples, a run of slots at a time.
#include "bundle_exchange/texels/slot_points.clh"
#include "lucarium/shared/surface_point.h"

// Every round takes another of a slot's points, of those that are open. levels: SlotOpenness::points().
__kernel void gather_points(LUCARIUM_SCENE_PARAMETERS AtlasInfo atlas_info,
                            __global const AtlasSample* restrict atlas_samples, __global const uint* restrict levels,
                            uint first, uint count, uint turn, __global SurfacePoint* restrict points,
                            __global float4* restrict samples) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  const uint slot = first + i;
  const AtlasSample sample = atlas_samples[(size_t)slot * SLOT_POINTS + slot_point(levels[slot], turn)];
  const Surface surface = slot_surface(&scene, atlas_info, slot, sample);
  SurfacePoint point;
  point.position = (float4)(surface.position, 0.0f);
  point.normal = (float4)(surface.n_g, 0.0f);
  point.u = sample.b1;
  point.v = sample.b2;
  point.triangle = sample.triangle;
  point.flags = 0u;
  points[i] = point;
  samples[i] = (float4)(0.0f);
}

// Each counts by the openness of its point.
__kernel void scatter_samples(uint first, uint count, uint turn, __global const uint* restrict levels,
                              __global const float4* restrict samples, __global float4* restrict light_samples) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const uint slot = first + i, level = levels[slot];
  light_samples[slot] += point_weight(level, slot_point(level, turn)) * samples[i];
}
