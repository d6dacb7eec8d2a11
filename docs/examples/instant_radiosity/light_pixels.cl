// SPDX-License-Identifier: Apache-2.0
// Virtual lights at what pixels see. The service traces, casts the shadow rays and calls the two functions.
#include "lucarium/bsdf.clh"
#include "lucarium/gbuffer.clh"
#include "lucarium/services/layer_sums/layer_sums.clh"
#define LIGHT_POINT_PARAMETERS __global const GBufferPoint *restrict points,
#define LIGHT_POINT_ARGUMENTS points,
#define LIGHT_SUM_PARAMETERS __global const GBufferPoint *restrict seen, __global float4 *restrict reflected,
#define LIGHT_SUM_ARGUMENTS seen, reflected,
#define LIGHT_POINT_STREAM 0x696e7261u  // random numbers apart from all others of the same seed
#include "lucarium/services/light_at_points/light_at_points.clh"

// The point that pixel i sees, if there is one.
bool light_point(const Scene* scene, uint i, LIGHT_POINT_PARAMETERS Surface* surface) {
  const GBufferPoint point = points[i];
  if (point.state != LUCARIUM_GBUFFER_SURFACE) return false;
  *surface = gbuffer_surface(scene, point);
  return true;
}

// reflected: the light [lx] of one virtual light, reflected towards the eye by the BSDF there [cd/m²].
void add_light(const Scene* scene, uint i, float3 light, float3 direction, float random,
               LIGHT_SUM_PARAMETERS uint samples) {
  if (is_black(light)) return;
  const GBufferPoint point = seen[i];
  const Surface surface = gbuffer_surface(scene, point);
  const Bsdf bsdf = make_bsdf(scene, &surface, 0u);
  const float3 f = eval_bsdf(&bsdf, direction) / dot(surface.n_s, direction);  // eval_bsdf has the cosine
  reflected[i] += (float4)(point.throughput.xyz * f * light, 0.0f);
}

// Adds a sample to the sums of the layers, when all of it is there.
__kernel void add_layers(__global const GBufferPoint* restrict points, uint count,
                         __global const float4* restrict reflected, __global float4* restrict emission,
                         __global float4* restrict indirect) {
  const uint i = (uint)get_global_id(0);
  if (i >= count) return;
  emission[i] = add_sample(emission[i], points[i].emission.xyz);
  indirect[i] = add_sample(indirect[i], reflected[i].xyz);
}
