// SPDX-License-Identifier: Apache-2.0
// Points that get light samples, virtual lights and photons: leaves, or visible points of a G-buffer (MICRO_PIXELS, for
// gather_visible=off), which get the light of their diffuse lobes.
#ifndef MICRO_PIXELS
#define MICRO_PIXELS 0
#endif
#ifndef MICRO_DYNAMIC
#define MICRO_DYNAMIC 0  // 1: leaves keep a sample for glossy lobes of nodes, see micro_dynamic.clh
#endif
#include "lucarium/gbuffer.clh"
#include "micro_rendering/tree/micro_dynamic.clh"
#include "micro_rendering/tree/micro_surface.clh"

#if MICRO_PIXELS
#define LIGHT_POINT_PARAMETERS __global const GBufferPoint *restrict points,
#define LIGHT_POINT_ARGUMENTS points,
#else
#define LIGHT_POINT_PARAMETERS __global const MicroLeaf *restrict leaves,
#define LIGHT_POINT_ARGUMENTS leaves,
#endif
#if MICRO_DYNAMIC
#define LIGHT_SUM_PARAMETERS \
  const float weight, __global float4 *restrict irradiance, __global MicroLeafLight *restrict leaf_lights,
#define LIGHT_SUM_ARGUMENTS weight, irradiance, leaf_lights,
#else
#define LIGHT_SUM_PARAMETERS const float weight, __global float4 *restrict irradiance,
#define LIGHT_SUM_ARGUMENTS weight, irradiance,
#endif
#define LIGHT_POINT_STREAM 0x6d6c6967u
#include "lucarium/services/light_at_points/light_at_points.clh"
#include "lucarium/services/light_at_points/photon_density.clh"

bool light_point(const Scene* scene, uint i, LIGHT_POINT_PARAMETERS Surface* surface) {
#if MICRO_PIXELS
  const GBufferPoint point = points[i];
  if (point.state != LUCARIUM_GBUFFER_SURFACE) return false;
  *surface = gbuffer_surface(scene, point);
#else
  *surface = leaf_surface(scene, leaves[i]);
#endif
  return true;
}

// Weighted so that the samples of one frame make a mean.
void add_light(const Scene* scene, uint i, float3 light, float3 direction, float random,
               LIGHT_SUM_PARAMETERS uint samples) {
  irradiance[i] += (float4)(weight * light, 0.0f);
#if MICRO_DYNAMIC
  if (!is_black(direction)) keep_light_sample(leaf_lights + i, direction, weight * light, random);
#endif
}
