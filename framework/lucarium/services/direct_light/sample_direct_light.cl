// SPDX-License-Identifier: Apache-2.0
// One light sample and, at pixels, one BSDF sample per point; what lies behind the rays is added by
// add_direct_light.cl.
#include "lucarium/eight/vertex_numbers.clh"
#include "lucarium/gbuffer.clh"
#include "lucarium/medium.clh"
#include "lucarium/scene.clh"
#include "lucarium/services/direct_light/light_strategies.clh"

// Apart from all other uses of the same seed.
#define DIRECT_LIGHT_STREAM 0x64697265u

// Work-item i draws the random numbers of pixels 8 i to 8 i + 7.
__kernel void draw_direct_numbers(uint count, uint sample_index, uint seed, __global float* restrict numbers) {
  const uint i = get_global_id(0);
  if (8u * i >= count) return;
  draw_vertex_numbers8(sampler_seeds(8u * i, DIRECT_LIGHT_STREAM, seed), (uint8)(sample_index), LUCARIUM_SAMPLER_SOBOL,
                       0u, false, i, numbers);
}

// numbers: of draw_direct_numbers().
// shadow_light: xyz what the pixel gets if shadow ray i is free; w: bits of the medium that BSDF ray i runs through.
// sides: of the pixels as lit points (light_tree.clh).
// bsdf_weights: xyz factor of the light that BSDF ray i meets; w: density of its direction [1/sr].
__kernel void sample_direct_radiance(LUCARIUM_SCENE_PARAMETERS __global const GBufferPoint* restrict points, uint count,
                                     uint kinds, __global const float* restrict numbers,
                                     LUCARIUM_RAY_ENDS_PARAMETER(shadow_ends) LUCARIUM_RAY_ENDS_PARAMETER(bsdf_ends)
                                         __global Ray* restrict shadow_rays,
                                     __global float4* restrict shadow_light, __global Ray* restrict bsdf_rays,
                                     __global float4* restrict bsdf_weights, __global uint* restrict sides) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  shadow_rays[i] = bsdf_rays[i] = inactive_ray();
  shadow_light[i] = bsdf_weights[i] = (float4)(0.0f);
  const GBufferPoint point = points[i];
  if (point.state != LUCARIUM_GBUFFER_SURFACE) return;

  // Rebuild the surface as the eye sees it.
  const Surface surface = gbuffer_surface(&scene, point);
  const Bsdf bsdf = make_bsdf(&scene, &surface, 0u);
  if (!bsdf_has_smooth_lobe(&bsdf)) return;

  const VertexNumbers drawn = vertex_numbers(numbers, i);
  const LightChoiceSample u = drawn.light;
  float3 light;
  Ray ray;
  RayEnds ends;
  const uint side = sides[i] = lit_side(&scene, &surface, &bsdf);
  const uint here = gbuffer_medium(point), behind = medium_behind(&scene, &surface, here);
  if (sample_light_at(&scene, &surface, &bsdf, side, u, here, true, kinds, drawn.shadow_seed, &light, &ray, &ends)) {
    shadow_rays[i] = ray;
    LUCARIUM_STORE_RAY_ENDS(shadow_ends, i, ends);
    shadow_light[i] = (float4)(point.throughput.xyz * light, 0.0f);
  }

  if (!(kinds & (1u << LUCARIUM_LIGHT_TRIANGLE | 1u << LUCARIUM_LIGHT_ENVIRONMENT))) return;  // nothing to be hit
  // Ideal lobes belong to the G-buffer's path: what they are sampled for here is left out.
  const BsdfSample sample = sample_bsdf_by(&bsdf, u.lobe, drawn.direction.direction, &drawn.cosine);
  if (sample.delta || is_black(sample.weight)) return;
  bsdf_rays[i] = make_ray(&surface, sample.direction, drawn.next_seed);
  LUCARIUM_STORE_RAY_ENDS(bsdf_ends, i, ray_ends(&surface, sample.direction));
  bsdf_weights[i] = (float4)(point.throughput.xyz * sample.weight, sample.pdf);
  shadow_light[i].w = as_float(sample.transmitted ? behind : here);
}
