// SPDX-License-Identifier: Apache-2.0
// SurfacePoints that keep the random numbers that come with a light sample: y that of the sample, and x that of its
// other ray, with z 1 where it has met a lamp.
#include "lucarium/shared/surface_point.h"
#define LIGHT_POINT_PARAMETERS __global const SurfacePoint *restrict points,
#define LIGHT_POINT_ARGUMENTS points,
#define LIGHT_SUM_PARAMETERS __global float4 *restrict irradiance,
#define LIGHT_SUM_ARGUMENTS irradiance,
#define LIGHT_POINT_STREAM 0x63686f73u
#include "lucarium/services/light_at_points/light_at_points.clh"
#include "lucarium/surface_point.clh"

bool light_point(const Scene* scene, uint i, LIGHT_POINT_PARAMETERS Surface* surface) {
  *surface = surface_hit_from(scene, points[i].triangle, points[i].u, points[i].v, -points[i].normal.xyz);
  return true;
}

void add_light(const Scene* scene, uint i, float3 light, float3 direction, float random,
               LIGHT_SUM_PARAMETERS uint samples) {
  irradiance[i] += samples ? (float4)(0.0f, random, 0.0f, (float)samples) : (float4)(random, 0.0f, 1.0f, 0.0f);
}
