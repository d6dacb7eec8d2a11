// SPDX-License-Identifier: Apache-2.0
// Gathers at some pixels only: the others are interpolated (Ritschel et al. 2009, section 2.4).
#include "lucarium/gbuffer.clh"
#include "lucarium/gbuffer_filter.clh"
#include "lucarium/sub_image.clh"
#include "micro_rendering/pixels/gather_keys.clh"
#include "micro_rendering/pixels/pixel_lobes.clh"
#include "micro_rendering/shared/micro_types.h"

#ifndef MICRO_GATHER_ENV
#define MICRO_GATHER_ENV 0  // as micro_gather.cl
#endif

float3 mirrored_view(const __global GBufferPoint* point) {
  const float3 n = point->shading.xyz, v = point->view.xyz;
  return 2.0f * dot(n, v) * n - v;
}

// Weighted sums over the gathers about a pixel; w: weights. The specular lobe in two parts, as gather_light has it.
typedef struct UpsampledSums {
  float4 diffuse, all, schlick_sum;
#if MICRO_GATHER_ENV
  float4 sky_diffuse, sky_all, sky_schlick;
#endif
} UpsampledSums;

// Normalizes by the weights, and stores what one pixel gets.
void store_upsampled(const UpsampledSums* sums, uint pixel, __global float4* irradiance, __global float4* specular
#if MICRO_GATHER_ENV
                     ,
                     __global float4* sky
#endif
) {
  const float4 diffuse = sums->diffuse, all = sums->all;
  irradiance[pixel] = diffuse.w > 0.0f ? (float4)(diffuse.xyz / diffuse.w, 0.0f) : (float4)(0.0f);
  specular[2u * pixel] = all.w > 0.0f ? (float4)(all.xyz / all.w, 0.0f) : (float4)(0.0f);
  specular[2u * pixel + 1u] = all.w > 0.0f ? (float4)(sums->schlick_sum.xyz / all.w, 0.0f) : (float4)(0.0f);
#if MICRO_GATHER_ENV
  sky[3u * pixel] = diffuse.w > 0.0f ? sums->sky_diffuse / diffuse.w : (float4)(0.0f);
  sky[3u * pixel + 1u] = all.w > 0.0f ? sums->sky_all / all.w : (float4)(0.0f);
  sky[3u * pixel + 2u] = all.w > 0.0f ? sums->sky_schlick / all.w : (float4)(0.0f);
#endif
}

// Bilateral upsampling (Ritschel et al. 2009, section 2.4).
// Results of all pixels between gathers, from the four around: irradiance by bilateral weights, the specular lobe only
// from pixels whose lobe is as wide and points the same way. Where the weights sum to less than `min_weight` the pixel
// gets a key (as make_gather_keys) and gathers itself. With `min_weight` 0 none does: where nothing agrees it takes
// what there is, which else would be black, and lobes need not point the same way. Footprint of a pixel: footprint.x ·
// distance + footprint.y [m].
__kernel void upsample_gathers(LUCARIUM_SCENE_PARAMETERS __global const GBufferPoint* restrict points, uint height,
                               const SubImage sub, float min_weight, float2 footprint, uint morton,
                               __global float4* restrict irradiance, __global float4* restrict specular,
                               __global MicroStatistics* restrict statistics, uint sides, __global uint* restrict keys,
                               __global uint* restrict values,
#if MICRO_GATHER_ENV
                               __global float4* restrict sky,
#endif
                               __global uint* restrict failed) {
  const uint pixel = get_global_id(0), width = sub.image_width, pixels = width * height;
  if (pixel >= pixels) return;
  const uint x = pixel % width, y = pixel / width;
  for (uint side = 0; side < sides; ++side) {
    keys[pixel + side * pixels] = MICRO_NO_GATHER;
    values[pixel + side * pixels] = pixel + side * pixels;
  }
  failed[pixel] = 0u;
  // The square of gathers about the pixel; at the borders half of it lies outside.
  const int stride = (int)sub.stride;
  const int x0 = sub_image_line(x, sub.offset_x, sub.stride), y0 = sub_image_line(y, sub.offset_y, sub.stride);
  if (x0 == (int)x && y0 == (int)y) return;
  const MicroStatistics none = {0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u};
  for (uint side = 0; side < sides; ++side) statistics[pixel + side * pixels] = none;
  // Find which lobes the pixel needs, and how far its surface may differ from a gather's.
  const __global GBufferPoint* point = points + pixel;
  if (point->state != LUCARIUM_GBUFFER_SURFACE) return;
  LUCARIUM_SCENE_BIND(scene);
  const Surface surface = gbuffer_surface(&scene, *point);
  const Bsdf bsdf = make_bsdf(&scene, &surface, 0u);
  const bool glossy = has_glossy_lobe(&bsdf);
  const float sigma = 2.0f * (float)stride * (footprint.x * point->position.w + footprint.y);
  const float3 mirrored = mirrored_view(point);
  // Lobes agree within a quarter of their width, alpha radians.
  const float same_way = min_weight > 0.0f ? 1.0f - 0.5f * sqr(0.25f * bsdf.alpha) : -2.0f;
  const float min_agreement = min_weight > 0.0f ? 0.0f : 1e-6f;

  UpsampledSums sums;
  sums.diffuse = sums.all = sums.schlick_sum = (float4)(0.0f);
#if MICRO_GATHER_ENV
  sums.sky_diffuse = sums.sky_all = sums.sky_schlick = (float4)(0.0f);
#endif
  // Add the four gathers, by bilinear weights times the agreement of normals and planes.
  const float fx = (float)((int)x - x0) / (float)stride, fy = (float)((int)y - y0) / (float)stride;
  for (uint corner = 0u; corner < 4u; ++corner) {
    const int cx = x0 + (int)(corner & 1u) * stride, cy = y0 + (int)(corner >> 1) * stride;
    if (cx < 0 || cy < 0 || cx >= (int)width || cy >= (int)height) continue;
    const uint other = (uint)cy * width + (uint)cx;
    if (points[other].state != LUCARIUM_GBUFFER_SURFACE) continue;
    const float bilinear = (corner & 1u ? fx : 1.0f - fx) * (corner >> 1 ? fy : 1.0f - fy);
    const float weight = bilinear * fmax(surface_agreement(point, points + other, sigma), min_agreement);
    if (!(weight > 0.0f)) continue;
    const Surface there = gbuffer_surface(&scene, points[other]);
    const Bsdf lobe = make_bsdf(&scene, &there, 0u);
    // A pixel that has no such lobe has not gathered for it.
    if (luminance(lobe.diffuse) > 0.0f) {
      sums.diffuse += weight * (float4)(irradiance[other].xyz, 1.0f);
#if MICRO_GATHER_ENV
      sums.sky_diffuse += weight * sky[3u * other];
#endif
    }
    // Take the specular lobe only from one as wide that points the same way.
    if (!glossy || !has_glossy_lobe(&lobe) || fabs(lobe.alpha - bsdf.alpha) > 0.1f * bsdf.alpha) continue;
    if (dot(mirrored, mirrored_view(points + other)) < same_way) continue;
    sums.all += weight * (float4)(specular[2u * other].xyz, 1.0f);
    sums.schlick_sum += weight * (float4)(specular[2u * other + 1u].xyz, 0.0f);
#if MICRO_GATHER_ENV
    sums.sky_all += weight * sky[3u * other + 1u];
    sums.sky_schlick += weight * sky[3u * other + 2u];
#endif
  }
#if MICRO_GATHER_ENV
  store_upsampled(&sums, pixel, irradiance, specular, sky);
#else
  store_upsampled(&sums, pixel, irradiance, specular);
#endif
  // What shines through is as sharp as what is mirrored, and is not interpolated.
  const bool through = sides == 2u && has_rough_transmission(&bsdf);
  const bool needs_diffuse = luminance(bsdf.diffuse) > 0.0f;
  if (!through && !(needs_diffuse && sums.diffuse.w < min_weight) && !(glossy && sums.all.w < min_weight)) return;
  // Let the pixel gather itself in an additional pass, as the paper does where weights are nearly zero.
  failed[pixel] = 1u;
  keys[pixel] = morton ? morton_of(scene.scene_info, point->position.xyz) : pixel;
  if (through) keys[pixel + pixels] = keys[pixel];
}
