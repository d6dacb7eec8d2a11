// SPDX-License-Identifier: Apache-2.0
// From the G-buffer to the list of gathers, and from their results to the image.
#include "lucarium/bsdf.clh"
#include "lucarium/gbuffer.clh"
#include "lucarium/gbuffer_filter.clh"
#include "lucarium/services/layer_sums/layer_sums.clh"
#include "lucarium/sub_image.clh"
#include "micro_rendering/shared/micro_types.h"
#include "micro_rendering/tree/micro_node.clh"

#ifndef MICRO_GATHER_ENV
#define MICRO_GATHER_ENV 0  // as micro_gather.cl
#endif
#ifndef MICRO_LEVELS
#define MICRO_LEVELS 0  // as micro_gather.cl
#endif

#define MICRO_NO_GATHER 0x40000000u  // key of a pixel that gathers nothing: behind all others

bool has_glossy_lobe(const Bsdf* bsdf) {
  return bsdf->p_reflect > 0.0f && !(bsdf->flags & LUCARIUM_BSDF_DELTA_REFLECTION);
}

bool has_rough_transmission(const Bsdf* bsdf) {
  return bsdf->p_transmit > 0.0f && !(bsdf->flags & LUCARIUM_BSDF_DELTA_TRANSMISSION);
}

// Edges of the micro-buffers: a lobe alone gets all of `size`; two share its pixels by luminance, at least 8 x 8 each.
uint2 micro_buffer_sizes(const Scene* scene, const Bsdf* bsdf, uint size) {
  const float diffuse = luminance(bsdf->diffuse);
  const bool glossy = has_glossy_lobe(bsdf);
  if (!glossy) return (uint2)(diffuse > 0.0f ? size : 0u, 0u);
  if (diffuse == 0.0f) return (uint2)(0u, size);
  const float specular = luminance(bsdf_average_albedo(scene, bsdf->f0, bsdf->f90, sqrt(bsdf->alpha)));
  const float pixels = (float)(size * size), share = specular / (specular + diffuse);
  const uint s = clamp((uint)(sqrt(share * pixels) + 0.5f), 8u, size);
  const uint d = clamp((uint)(sqrt(fmax(pixels - (float)(s * s), 0.0f)) + 0.5f), 8u, size);
  return (uint2)(d, s);
}

// 30-bit Morton code of a point of the scene: the space-filling curve of Ritschel et al. 2009, section 3.2.
uint morton_of(const global SceneInfo* info, float3 position) {
  const float3 low = info->bounds_min.xyz, extent = info->bounds_max.xyz - low;
  const float scale = 1024.0f / fmax(max_component(extent), FLT_MIN);
  uint3 x = convert_uint3(clamp((position - low) * scale, 0.0f, 1023.0f));
  x = (x | (x << 16)) & 0x030000ffu;
  x = (x | (x << 8)) & 0x0300f00fu;
  x = (x | (x << 4)) & 0x030c30c3u;
  x = (x | (x << 2)) & 0x09249249u;
  return x.x | (x.y << 1) | (x.z << 2);
}

// Enumerates the gathers so that neighbours of the list compute alike cuts (Ritschel et al. 2009, section 3.2).
// keys: Morton order of the points, or of the pixels; values: the slots. Slots are pixels, and behind `pixels` of them
// the far sides of surfaces that transmit: entry i + capacity is that of entry i, where sides is 2.
__kernel void mr_list_keys(LUCARIUM_SCENE_PARAMETERS __global const GBufferPoint* restrict points, const SubImage sub,
                           const uint morton, const uint capacity, const uint pixels, const uint sides,
                           __global MicroStatistics* restrict statistics, __global uint* restrict keys,
                           __global uint* restrict values) {
  const uint i = get_global_id(0);
  if (i >= capacity) return;
  // Begin with no gather anywhere; work-items beyond the sub-image only fill up the list.
  for (uint side = 0; side < sides; ++side) {
    keys[i + side * capacity] = MICRO_NO_GATHER;
    values[i + side * capacity] = 0u;
  }
  if (i >= sub.width * sub.height) return;
  LUCARIUM_SCENE_BIND(scene);
  const uint pixel = sub_image_pixel(sub, i);
  const MicroStatistics none = {0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u};
  for (uint side = 0; side < sides; ++side) statistics[pixel + side * pixels] = none;
  if (points[pixel].state != LUCARIUM_GBUFFER_SURFACE) return;
  values[i] = pixel;
  keys[i] = morton ? morton_of(scene_info, points[pixel].position.xyz) : i;
  if (sides == 1u) return;
  const Surface surface = gbuffer_surface(&scene, points[pixel]);
  const Bsdf bsdf = make_bsdf(&scene, &surface, 0u);
  if (!has_rough_transmission(&bsdf)) return;
  // Add a gather on the far side, where the surface transmits.
  values[i + capacity] = pixel + pixels;
  keys[i + capacity] = keys[i];
}

#if MICRO_LEVELS
// Whether frames differ by more than `adaptive` of their mean; below 0 all do, at 0 none.
bool needs_more(float4 level, float adaptive) {
  const float frames = fabs(level.w);
  return adaptive < 0.0f ||
         (adaptive > 0.0f && frames > 1.5f && level.z > sqr(adaptive * (level.x + level.y)) * (frames - 1.0f));
}
#endif

// Writes the gathers of the sorted pixels; gather_count[0] becomes their number.
__kernel void mr_list_fill(LUCARIUM_SCENE_PARAMETERS __global const GBufferPoint* restrict points,
                           __global const uint* restrict keys, __global const uint* restrict values, const uint count,
                           const uint pixels, const uint micro_size, __global const MicroPatch* restrict patches,
#if MICRO_LEVELS
                           __global const float4* restrict levels, const float adaptive, const uint larger,
#endif
                           __global MicroGather* restrict gathers, __global uint* restrict gather_count) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  // Count the gathers: the last of the sorted keys that is one knows their number.
  const bool mine = keys[i] < MICRO_NO_GATHER;
  if (i == 0u && !mine) gather_count[0] = 0u;
  if (mine && (i + 1u == count || keys[i + 1u] >= MICRO_NO_GATHER)) gather_count[0] = i + 1u;
  if (!mine) return;
  LUCARIUM_SCENE_BIND(scene);
  const uint pixel = values[i] % pixels;
  const bool through = values[i] >= pixels;
  const Surface surface = gbuffer_surface(&scene, points[pixel]);
  const Bsdf bsdf = make_bsdf(&scene, &surface, 0u);
  // Choose the edges of the micro-buffers.
  uint size = micro_size;
#if MICRO_LEVELS
  if (needs_more(levels[pixel], adaptive)) size = larger;
#endif
  const uint2 sizes = through ? (uint2)(0u, size) : micro_buffer_sizes(&scene, &bsdf, size);
  // Write the gather; through a surface everything is mirrored to its far side.
  ushort alpha;
  vstore_half(bsdf.alpha, 0, (half*)&alpha);
  MicroGather gather;
  gather.position = (float4)(surface.position, as_float(values[i]));
  const float3 n_s = through ? -surface.n_s : surface.n_s;
  gather.normal = pack_direction(n_s);
  gather.geometric = pack_direction(through ? -surface.n_g : surface.n_g);
  gather.view =
      pack_direction(through ? surface.view - 2.0f * dot(surface.n_s, surface.view) * surface.n_s : surface.view);
  gather.lobes = sizes.x | (sizes.y << 8) | ((uint)alpha << 16);
  const bool front = (surface.flags & LUCARIUM_SURFACE_FRONT) != 0u;
  gather.hidden = MICRO_SIDE(patches[points[pixel].triangle].sheet, front != through);
  gather.eta = through ? (bsdf.flags & LUCARIUM_BSDF_THIN ? 0.0f : bsdf.eta) : bsdf.eta > 1.0f ? -bsdf.eta : 0.0f;
  gathers[i] = gather;
}

// ---- gathers at some pixels only

float3 mirrored_view(const global GBufferPoint* point) {
  const float3 n = point->shading.xyz, v = point->view.xyz;
  return 2.0f * dot(n, v) * n - v;
}

// Bilateral upsampling (Ritschel et al. 2009, section 2.4).
// Results of all pixels between gathers, from the four around: irradiance by bilateral weights, the specular lobe only
// from pixels whose lobe is as wide and points the same way. Where the weights sum to less than `least` the pixel gets
// a key (as mr_list_keys) and gathers itself. With `least` 0 none does: where nothing agrees it takes what there is,
// which else would be black, and lobes need not point the same way. Footprint of a pixel: footprint.x · distance +
// footprint.y [m].
__kernel void mr_upsample(LUCARIUM_SCENE_PARAMETERS __global const GBufferPoint* restrict points, const uint height,
                          const SubImage sub, const float least, const float2 footprint, const uint morton,
                          __global float4* restrict irradiance, __global float4* restrict specular,
                          __global MicroStatistics* restrict statistics, const uint sides, __global uint* restrict keys,
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
  const global GBufferPoint* point = points + pixel;
  if (point->state != LUCARIUM_GBUFFER_SURFACE) return;
  LUCARIUM_SCENE_BIND(scene);
  const Surface surface = gbuffer_surface(&scene, *point);
  const Bsdf bsdf = make_bsdf(&scene, &surface, 0u);
  const bool glossy = has_glossy_lobe(&bsdf);
  const float sigma = 2.0f * (float)stride * (footprint.x * point->position.w + footprint.y);
  const float3 mirrored = mirrored_view(point);
  // Lobes agree within a quarter of their width, alpha radians.
  const float same_way = least > 0.0f ? 1.0f - 0.5f * sqr(0.25f * bsdf.alpha) : -2.0f;
  const float least_agreement = least > 0.0f ? 0.0f : 1e-6f;

  float4 diffuse = (float4)(0.0f), all = (float4)(0.0f), grazing = (float4)(0.0f);
#if MICRO_GATHER_ENV
  float4 sky_diffuse = (float4)(0.0f), sky_all = (float4)(0.0f), sky_grazing = (float4)(0.0f);
#endif
  // Add the four gathers, by bilinear weights times the agreement of normals and planes.
  const float fx = (float)((int)x - x0) / (float)stride, fy = (float)((int)y - y0) / (float)stride;
  for (uint corner = 0u; corner < 4u; ++corner) {
    const int cx = x0 + (int)(corner & 1u) * stride, cy = y0 + (int)(corner >> 1) * stride;
    if (cx < 0 || cy < 0 || cx >= (int)width || cy >= (int)height) continue;
    const uint other = (uint)cy * width + (uint)cx;
    if (points[other].state != LUCARIUM_GBUFFER_SURFACE) continue;
    const float bilinear = (corner & 1u ? fx : 1.0f - fx) * (corner >> 1 ? fy : 1.0f - fy);
    const float weight = bilinear * fmax(surface_agreement(point, points + other, sigma), least_agreement);
    if (!(weight > 0.0f)) continue;
    const Surface there = gbuffer_surface(&scene, points[other]);
    const Bsdf lobe = make_bsdf(&scene, &there, 0u);
    // A pixel that has no such lobe has not gathered for it.
    if (luminance(lobe.diffuse) > 0.0f) {
      diffuse += weight * (float4)(irradiance[other].xyz, 1.0f);
#if MICRO_GATHER_ENV
      sky_diffuse += weight * sky[3u * other];
#endif
    }
    // Take the specular lobe only from one as wide that points the same way.
    if (!glossy || !has_glossy_lobe(&lobe) || fabs(lobe.alpha - bsdf.alpha) > 0.1f * bsdf.alpha) continue;
    if (dot(mirrored, mirrored_view(points + other)) < same_way) continue;
    all += weight * (float4)(specular[2u * other].xyz, 1.0f);
    grazing += weight * (float4)(specular[2u * other + 1u].xyz, 0.0f);
#if MICRO_GATHER_ENV
    sky_all += weight * sky[3u * other + 1u];
    sky_grazing += weight * sky[3u * other + 2u];
#endif
  }
  // Normalize by the weights.
  const bool needs_diffuse = luminance(bsdf.diffuse) > 0.0f;
  irradiance[pixel] = diffuse.w > 0.0f ? (float4)(diffuse.xyz / diffuse.w, 0.0f) : (float4)(0.0f);
  specular[2u * pixel] = all.w > 0.0f ? (float4)(all.xyz / all.w, 0.0f) : (float4)(0.0f);
  specular[2u * pixel + 1u] = all.w > 0.0f ? (float4)(grazing.xyz / all.w, 0.0f) : (float4)(0.0f);
#if MICRO_GATHER_ENV
  sky[3u * pixel] = diffuse.w > 0.0f ? sky_diffuse / diffuse.w : (float4)(0.0f);
  sky[3u * pixel + 1u] = all.w > 0.0f ? sky_all / all.w : (float4)(0.0f);
  sky[3u * pixel + 2u] = all.w > 0.0f ? sky_grazing / all.w : (float4)(0.0f);
#endif
  // What shines through is as sharp as what is mirrored, and is not interpolated.
  const bool through = sides == 2u && has_rough_transmission(&bsdf);
  if (!through && !(needs_diffuse && diffuse.w < least) && !(glossy && all.w < least)) return;
  // Let the pixel gather itself in an additional pass, as the paper does where weights are nearly zero.
  failed[pixel] = 1u;
  keys[pixel] = morton ? morton_of(scene.scene_info, point->position.xyz) : pixel;
  if (through) keys[pixel + pixels] = keys[pixel];
}

// What a point reflects of a gather's results: irradiance, and S and S_w of the specular lobe.
float3 reflected_light(const Bsdf* bsdf, float3 irradiance, float3 all, float3 grazing) {
  float3 light = (float3)(0.0f);
  if (luminance(bsdf->diffuse) > 0.0f) light += bsdf->diffuse * irradiance * M_1_PI_F;
  if (has_glossy_lobe(bsdf)) light += bsdf->f0 * (all - grazing) + bsdf->f90 * grazing;
  return light;
}

// What it transmits, from the same of its far side.
float3 transmitted_light(const Bsdf* bsdf, float3 all, float3 grazing) {
  return bsdf->transmission *
         ((1.0f - bsdf->dielectric_f0) * all - (bsdf->dielectric_f90 - bsdf->dielectric_f0) * grazing);
}

// Adds the light that the pixels of a sub-image reflect: xyz sum, w samples; sky_light: of the environment. looks: sums
// of what the inspection layers show, x mean level of the cut, y leaves that were ray-cast, z nodes visited, w 1 where
// interpolation failed. Pixels that did not gather show the gather of `lattice` that they lie beside.
__kernel void mr_add_indirect(LUCARIUM_SCENE_PARAMETERS __global const GBufferPoint* restrict points,
                              const SubImage sub, const SubImage lattice, __global const float4* restrict irradiance,
                              __global const float4* restrict specular,
                              __global const MicroStatistics* restrict statistics, __global const uint* restrict failed,
                              const uint pixels, const uint sides, __global float4* restrict indirect,
#if MICRO_LEVELS
                              __global float4* restrict levels,
#endif
#if MICRO_GATHER_ENV
                              __global const float4* restrict sky, __global float4* restrict sky_light,
#endif
                              __global float4* restrict looks) {
  const uint i = get_global_id(0);
  if (i >= sub.width * sub.height) return;
  LUCARIUM_SCENE_BIND(scene);
  const uint pixel = sub_image_pixel(sub, i);
  float3 light = (float3)(0.0f);
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
#if MICRO_GATHER_ENV
    float3 from_sky = reflected_light(&bsdf, sky[3u * pixel].xyz, sky[3u * pixel + 1u].xyz, sky[3u * pixel + 2u].xyz);
    if (through) from_sky += transmitted_light(&bsdf, sky[3u * far + 1u].xyz, sky[3u * far + 2u].xyz);
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
    looks[pixel] += (float4)((float)shown.levels / (float)max(shown.splats + shown.listed, 1u), (float)shown.listed,
                             (float)shown.visits, (float)failed[pixel]);
  }
  indirect[pixel] = add_sample(indirect[pixel], light);
}

// Sums over runs of `run` pixels of a sub-image.
__kernel void mr_sum_statistics(__global const GBufferPoint* restrict points, const SubImage sub, const uint run,
                                __global const MicroStatistics* restrict statistics, const uint pixels,
                                const uint sides, __global MicroStatistics* restrict sums) {
  const uint first = get_global_id(0) * run, end = min(first + run, sub.width * sub.height);
  MicroStatistics sum = {0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u};
  for (uint i = first; i < end; ++i) {
    const uint pixel = sub_image_pixel(sub, i);
    if (points[pixel].state != LUCARIUM_GBUFFER_SURFACE) continue;
    for (uint side = 0; side < sides; ++side) {
      const MicroStatistics s = statistics[pixel + side * pixels];
      sum.visits += s.visits;
      sum.splats += s.splats;
      sum.listed += s.listed;
      sum.disc_tests += s.disc_tests;
      sum.holes += s.holes;
      sum.flushes += s.flushes;
      sum.levels += s.listed > 0u;
      sum.uneven += s.visits > 0u;
    }
  }
  sums[get_global_id(0)] = sum;
}

// Keeps the micro-buffer of the inspected pixel.
__kernel void mr_keep_micro_buffer(__global const float4* restrict micro_buffer, const uint count,
                                   __global float4* restrict kept) {
  const uint i = get_global_id(0);
  if (i < count) kept[i] = micro_buffer[i];
}
