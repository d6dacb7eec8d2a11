// SPDX-License-Identifier: Apache-2.0
// From the results of gathers to the light of pixels.
#include "lucarium/gbuffer.clh"
#include "lucarium/services/layer_sums/layer_sums.clh"
#include "lucarium/sub_image.clh"
#include "micro_rendering/pixels/pixel_lobes.clh"
#include "micro_rendering/shared/micro_types.h"

#ifndef MICRO_GATHER_ENV
#define MICRO_GATHER_ENV 0  // as micro_gather.cl
#endif
#ifndef MICRO_LEVELS
#define MICRO_LEVELS 0  // as micro_gather.cl
#endif

// What a point reflects of a gather's results: irradiance, and S and S_w of the specular lobe.
float3 reflected_light(const Bsdf* bsdf, float3 irradiance, float3 all, float3 schlick_sum) {
  float3 light = (float3)(0.0f);
  if (luminance(bsdf->diffuse) > 0.0f) light += bsdf->diffuse * irradiance * M_1_PI_F;
  if (has_glossy_lobe(bsdf)) light += bsdf->f0 * (all - schlick_sum) + bsdf->f90 * schlick_sum;
  return light;
}

// What it transmits, from the same of its far side.
float3 transmitted_light(const Bsdf* bsdf, float3 all, float3 schlick_sum) {
  return bsdf->transmission *
         ((1.0f - bsdf->dielectric_f0) * all - (bsdf->dielectric_f90 - bsdf->dielectric_f0) * schlick_sum);
}

// Adds the light that the pixels of a sub-image reflect: xyz sum, w samples; sky_light: of the environment. inspected:
// sums of what the inspection layers show, x mean level of the cut, y leaves that were ray-cast, z nodes visited, w 1
// where interpolation failed. deviations: of this frame's light from the mean of the frames before. Pixels that did not
// gather show the gather of `lattice` that they lie beside.
__kernel void add_indirect_light(LUCARIUM_SCENE_PARAMETERS __global const GBufferPoint* restrict points,
                                 const SubImage sub, const SubImage lattice, __global const float4* restrict irradiance,
                                 __global const float4* restrict specular,
                                 __global const MicroStatistics* restrict statistics,
                                 __global const uint* restrict failed, uint pixels, uint sides,
                                 __global float4* restrict indirect,
#if MICRO_LEVELS
                                 __global float4* restrict levels,
#endif
#if MICRO_GATHER_ENV
                                 __global const float4* restrict sky, __global float4* restrict sky_light,
#endif
                                 __global float* restrict deviations, __global float4* restrict inspected) {
  const uint i = get_global_id(0);
  if (i >= sub.width * sub.height) return;
  LUCARIUM_SCENE_BIND(scene);
  const uint pixel = sub_image_pixel(sub, i);
  float3 light = (float3)(0.0f), gathered = (float3)(0.0f), sum_before = indirect[pixel].xyz;
#if MICRO_GATHER_ENV
  sum_before += sky_light[pixel].xyz;
#endif
  if (points[pixel].state == LUCARIUM_GBUFFER_SURFACE) {
    // Reflect and transmit what was gathered, by the pixel's own material.
    const Surface surface = gbuffer_surface(&scene, points[pixel]);
    const Bsdf bsdf = make_bsdf(&scene, &surface, 0u);
    const float3 throughput = points[pixel].throughput.xyz;
    const uint far = pixel + pixels;
    const bool through = sides == 2u && has_rough_transmission(&bsdf);
    light = reflected_light(&bsdf, irradiance[pixel].xyz, specular[2u * pixel].xyz, specular[2u * pixel + 1u].xyz);
    if (through) light += transmitted_light(&bsdf, specular[2u * far].xyz, specular[2u * far + 1u].xyz);
    light *= throughput;
    gathered = light;
#if MICRO_GATHER_ENV
    float3 from_sky = reflected_light(&bsdf, sky[3u * pixel].xyz, sky[3u * pixel + 1u].xyz, sky[3u * pixel + 2u].xyz);
    if (through) from_sky += transmitted_light(&bsdf, sky[3u * far + 1u].xyz, sky[3u * far + 2u].xyz);
    gathered += throughput * from_sky;
    sky_light[pixel] += (float4)(throughput * from_sky, 0.0f);
#endif
    const MicroStatistics s = statistics[pixel];
#if MICRO_LEVELS
    // Follow the mean and its variance over the frames: what the next cut may err by, and where more is needed.
    if (s.visits > 0u) {
      const float2 now =
          (float2)(M_1_PI_F * max_component(irradiance[pixel].xyz),
                   max_component(specular[2u * pixel].xyz) + (through ? max_component(specular[2u * far].xyz) : 0.0f));
      const float4 before = levels[pixel];
      const float frames = fabs(before.w) + 1.0f;
      const float2 mean = mix(before.xy, now, 1.0f / frames);
      const float squares = (now.x + now.y - before.x - before.y) * (now.x + now.y - mean.x - mean.y);  // Welford 1962
      levels[pixel] = (float4)(mean, before.z + squares, s.uneven ? frames : -frames);
    }
#endif
    // Add to the inspection layers.
    const MicroStatistics shown = s.visits > 0u ? s : statistics[sub_image_neighbour(lattice, pixel)];
    inspected[pixel] += (float4)((float)shown.levels / (float)max(shown.splats + shown.listed, 1u), (float)shown.listed,
                                 (float)shown.visits, (float)failed[pixel]);
  }
  const float frames = indirect[pixel].w;
  deviations[pixel] = sample_deviation(gathered, sum_before / fmax(frames, 1.0f), frames);
  indirect[pixel] = add_sample(indirect[pixel], light);
}
