// SPDX-License-Identifier: Apache-2.0
// From the G-buffer to the list of gathers, and from their results to the image.
#include "lucarium/bsdf.clh"
#include "lucarium/shared/gbuffer.h"
#include "micro_rendering/micro_node.clh"
#include "micro_rendering/shared/micro_types.h"

#define MICRO_NO_GATHER 0x40000000u  // key of a pixel that gathers nothing: behind all others

uint sub_image_pixel(MicroSubImage sub, uint i) {
  const uint x = sub.offset_x + (i % sub.width) * sub.stride, y = sub.offset_y + (i / sub.width) * sub.stride;
  return y * sub.image_width + x;
}

Surface gbuffer_surface(const Scene* scene, const global GBufferPoint* point) {
  Hit hit;
  hit.distance = point->position.w;
  hit.triangle = point->triangle;
  hit.u = point->u;
  hit.v = point->v;
  return make_surface(scene, hit, -point->view.xyz, 0u);
}

bool has_glossy_lobe(const Bsdf* bsdf) { return bsdf->p_reflect > 0.0f && !(bsdf->flags & LUCARIUM_BSDF_DELTA_REFLECTION); }

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

// keys: Morton order of the points, or of the pixels; values: the pixels.
__kernel void mr_list_keys(__global const SceneInfo* restrict scene_info, __global const GBufferPoint* restrict points,
                           const MicroSubImage sub, const uint morton, const uint capacity,
                           __global uint* restrict keys, __global uint* restrict values) {
  const uint i = get_global_id(0);
  if (i >= capacity) return;
  keys[i] = MICRO_NO_GATHER;
  values[i] = 0u;
  if (i >= sub.width * sub.height) return;
  const uint pixel = sub_image_pixel(sub, i);
  values[i] = pixel;
  if (points[pixel].state != LUCARIUM_GBUFFER_SURFACE) return;
  if (!morton) {
    keys[i] = i;
    return;
  }
  const float3 low = scene_info->bounds_min.xyz, extent = scene_info->bounds_max.xyz - low;
  const float scale = 1024.0f / fmax(max_component(extent), FLT_MIN);
  uint3 x = convert_uint3(clamp((points[pixel].position.xyz - low) * scale, 0.0f, 1023.0f));
  x = (x | (x << 16)) & 0x030000ffu;
  x = (x | (x << 8)) & 0x0300f00fu;
  x = (x | (x << 4)) & 0x030c30c3u;
  x = (x | (x << 2)) & 0x09249249u;
  keys[i] = x.x | (x.y << 1) | (x.z << 2);
}

// Writes the gathers of the sorted pixels; gather_count[0] becomes their number.
__kernel void mr_list_fill(LUCARIUM_SCENE_PARAMETERS __global const GBufferPoint* restrict points,
                           __global const uint* restrict keys, __global const uint* restrict values, const uint count,
                           const uint micro_size, __global MicroGather* restrict gathers,
                           __global uint* restrict gather_count) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const bool mine = keys[i] < MICRO_NO_GATHER;
  if (i == 0u && !mine) gather_count[0] = 0u;
  if (mine && (i + 1u == count || keys[i + 1u] >= MICRO_NO_GATHER)) gather_count[0] = i + 1u;
  if (!mine) return;
  LUCARIUM_SCENE_BIND(scene);
  const Surface surface = gbuffer_surface(&scene, points + values[i]);
  const Bsdf bsdf = make_bsdf(&scene, &surface, 0u);
  const uint2 sizes = micro_buffer_sizes(&scene, &bsdf, micro_size);
  ushort alpha;
  vstore_half(bsdf.alpha, 0, (half*)&alpha);
  MicroGather gather;
  gather.position = (float4)(surface.position, as_float(values[i]));
  gather.normal = pack_direction(surface.n_s);
  gather.geometric = pack_direction(surface.n_g);
  gather.view = pack_direction(surface.view);
  gather.lobes = sizes.x | (sizes.y << 8) | ((uint)alpha << 16);
  gathers[i] = gather;
}

// Adds the light that the pixels of a sub-image reflect: xyz sum, w samples. looks: sums of what the inspection layers
// show, x mean level of the cut, y leaves that were ray-cast, z nodes visited, w 0.
__kernel void mr_add_indirect(LUCARIUM_SCENE_PARAMETERS __global const GBufferPoint* restrict points,
                              const MicroSubImage sub, __global const float4* restrict irradiance,
                              __global const float4* restrict specular, __global const MicroStatistics* restrict statistics,
                              __global float4* restrict indirect, __global float4* restrict looks) {
  const uint i = get_global_id(0);
  if (i >= sub.width * sub.height) return;
  LUCARIUM_SCENE_BIND(scene);
  const uint pixel = sub_image_pixel(sub, i);
  float3 light = (float3)(0.0f);
  if (points[pixel].state == LUCARIUM_GBUFFER_SURFACE) {
    const Surface surface = gbuffer_surface(&scene, points + pixel);
    const Bsdf bsdf = make_bsdf(&scene, &surface, 0u);
    if (luminance(bsdf.diffuse) > 0.0f) light += bsdf.diffuse * irradiance[pixel].xyz * M_1_PI_F;
    if (has_glossy_lobe(&bsdf)) {
      const float3 all = specular[2u * pixel].xyz, grazing = specular[2u * pixel + 1u].xyz;
      light += bsdf.f0 * (all - grazing) + bsdf.f90 * grazing;
    }
    light *= points[pixel].throughput.xyz;
    const MicroStatistics s = statistics[pixel];
    looks[pixel] += (float4)((float)s.levels / (float)max(s.splats + s.listed, 1u), (float)s.listed, (float)s.visits, 0.0f);
  }
  indirect[pixel] += (float4)(light, 1.0f);
}

// Adds what is seen itself.
__kernel void mr_add_emission(__global const GBufferPoint* restrict points, const uint count,
                              __global float4* restrict emission) {
  const uint i = get_global_id(0);
  if (i < count) emission[i] += (float4)(points[i].emission.xyz, 1.0f);
}

// Sums over runs of `run` pixels of a sub-image.
__kernel void mr_sum_statistics(__global const GBufferPoint* restrict points, const MicroSubImage sub, const uint run,
                                __global const MicroStatistics* restrict statistics,
                                __global MicroStatistics* restrict sums) {
  const uint first = get_global_id(0) * run, end = min(first + run, sub.width * sub.height);
  MicroStatistics sum = {0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u};
  for (uint i = first; i < end; ++i) {
    const uint pixel = sub_image_pixel(sub, i);
    if (points[pixel].state != LUCARIUM_GBUFFER_SURFACE) continue;
    const MicroStatistics s = statistics[pixel];
    sum.visits += s.visits;
    sum.splats += s.splats;
    sum.listed += s.listed;
    sum.disc_tests += s.disc_tests;
    sum.holes += s.holes;
    sum.flushes += s.flushes;
    sum.levels += s.listed > 0u;
    sum.pad += 1u;
  }
  sums[get_global_id(0)] = sum;
}

// Keeps the micro-buffer of the inspected pixel.
__kernel void mr_keep_micro_buffer(__global const float4* restrict micro_buffer, const uint count,
                                   __global float4* restrict kept) {
  const uint i = get_global_id(0);
  if (i < count) kept[i] = micro_buffer[i];
}
