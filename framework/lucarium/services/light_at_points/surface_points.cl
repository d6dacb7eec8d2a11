// SPDX-License-Identifier: Apache-2.0
// Irradiance at SurfacePoints, by the cosine to their normals; w counts the samples (DirectLight).
#include "lucarium/shared/surface_point.h"
#define LIGHT_POINT_PARAMETERS __global const SurfacePoint *restrict points,
#define LIGHT_POINT_ARGUMENTS points,
#define LIGHT_SUM_PARAMETERS __global float4 *restrict irradiance,
#define LIGHT_SUM_ARGUMENTS irradiance,
#define LIGHT_POINT_STREAM 0x64697265u
#include "lucarium/services/light_at_points/light_at_points.clh"

bool light_point(const Scene* scene, uint i, LIGHT_POINT_PARAMETERS Surface* surface) {
  Hit hit;
  hit.distance = 0.0f;
  hit.triangle = points[i].triangle;
  hit.u = points[i].u;
  hit.v = points[i].v;
  *surface = make_surface(scene, hit, -points[i].normal.xyz, 0u);
  surface->position = points[i].position.xyz;
  surface->n_s = points[i].normal.xyz;
  return true;
}

void add_light(const Scene* scene, uint i, float3 light, float3 direction, float random,
               LIGHT_SUM_PARAMETERS uint none) {
  irradiance[i] += (float4)(light, 1.0f);
}
