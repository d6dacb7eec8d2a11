// SPDX-License-Identifier: Apache-2.0
// From the G-buffer to the list of gathers.
#include "lucarium/gbuffer.clh"
#include "lucarium/sub_image.clh"
#include "micro_rendering/pixels/gather_keys.clh"
#include "micro_rendering/pixels/pixel_lobes.clh"
#include "micro_rendering/shared/micro_types.h"
#include "micro_rendering/tree/micro_node.clh"

#ifndef MICRO_LEVELS
#define MICRO_LEVELS 0  // as micro_gather.cl
#endif

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

// Enumerates the gathers so that neighbours of the list compute alike cuts (Ritschel et al. 2009, section 3.2).
// keys: Morton order of the points, or of the pixels; values: indices of results, which are pixels, and behind `pixels`
// of them the far sides of surfaces that transmit: entry i + capacity is that of entry i, where sides is 2.
__kernel void make_gather_keys(LUCARIUM_SCENE_PARAMETERS __global const GBufferPoint* restrict points,
                               const SubImage sub, uint morton, uint capacity, uint pixels, uint sides,
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
__kernel void list_gathers(LUCARIUM_SCENE_PARAMETERS __global const GBufferPoint* restrict points,
                           __global const uint* restrict keys, __global const uint* restrict values, uint count,
                           uint pixels, uint micro_size, __global const TriangleEdges* restrict triangle_edges,
#if MICRO_LEVELS
                           __global const float4* restrict levels, float adaptive, uint larger,
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
  gather.hidden = MICRO_SIDE(triangle_edges[points[pixel].triangle].sheet, front != through);
  gather.eta = through ? (bsdf.flags & LUCARIUM_BSDF_THIN ? 0.0f : bsdf.eta) : bsdf.eta > 1.0f ? -bsdf.eta : 0.0f;
  gathers[i] = gather;
}
