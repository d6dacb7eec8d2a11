// SPDX-License-Identifier: Apache-2.0
// Direct irradiance of slots by light samples, a run of slots at a time.
#include "lucarium/shared/surface_point.h"

__kernel void gather_points(uint first, uint count, __global const SurfacePoint* restrict atlas_points,
                            __global SurfacePoint* restrict points, __global float4* restrict samples) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  points[i] = atlas_points[first + i];
  samples[i] = (float4)(0.0f);
}

__kernel void scatter_samples(uint first, uint count, __global const float4* restrict samples,
                              __global float4* restrict light_samples) {
  const uint i = get_global_id(0);
  if (i < count) light_samples[first + i] += samples[i];
}
