// SPDX-License-Identifier: Apache-2.0
// Gathers light at points: one work-item per gather, in groups of one.
#include "micro_rendering/gather/micro_gather.clh"

#ifndef MICRO_LEVELS
#define MICRO_LEVELS 0  // 1: what the frames before have found is known (MICRO_ERROR_CUT)
#endif
#ifndef MICRO_GATHER_ENV
#define MICRO_GATHER_ENV 0  // 1: empty micro-pixels see the environment
#endif
#if MICRO_GATHER_ENV
#include "micro_rendering/gather/micro_sky.clh"
#endif

// The micro-buffer of the inspected result: radiance and distance [m]; -1: empty.
void store_micro_buffer(const MicroWarp* warp, const MicroPoint* point, const MicroBuffer* buffer,
                        const MicroNodeLight* light, float unit, __global float4* micro_buffer) {
  for (uint y = 0; y < warp->edge; ++y) {
    for (uint x = 0; x < warp->edge; ++x) {
      const uint i = (y + 1u) * buffer->rows + x + 1u;
      const ulong key = buffer->key[i];
      float4 pixel = (float4)(0.0f, 0.0f, 0.0f, -1.0f);
      if (key != MICRO_EMPTY) {
        const float3 w = (float3)(buffer->x[i], buffer->y[i], buffer->z[i]);
        pixel = (float4)(unit * pixel_radiance(light, point, w, key), as_float((uint)(key >> 32)));
      }
      micro_buffer[y * MICRO_SIZE + x] = pixel;
    }
  }
}

// The light of one lobe, without the factors that vary from pixel to pixel: irradiance without the albedo, and the
// specular lobe in the two parts that f0 and f90 weight.
void store_light(uint lobe, uint result, float unit, float4 light, float3 schlick_sum, __global float4* irradiance,
                 __global float4* specular) {
  if (lobe == MICRO_LOBE_DIFFUSE) {
    irradiance[result] = (float4)(M_PI_F * unit * light.xyz, light.w);
  } else {
    specular[2u * result] = (float4)(unit * light.xyz, 0.0f);
    specular[2u * result + 1u] = (float4)(unit * schlick_sum, 0.0f);
  }
}

#if MICRO_GATHER_ENV
// The same of the environment that empty micro-pixels see.
void store_sky(const Scene* scene, const MicroWarp* warp, const MicroPoint* point, const MicroBuffer* buffer, uint lobe,
               __global float4* sky) {
  float3 schlick_sky;
  const float3 plain_sky = micro_sky(scene, warp, point, buffer, &schlick_sky);
  if (lobe == MICRO_LOBE_DIFFUSE) {
    sky[3u * point->result] = (float4)(M_PI_F * plain_sky, 0.0f);
  } else {
    sky[3u * point->result + 1u] = (float4)(plain_sky, 0.0f);
    sky[3u * point->result + 2u] = (float4)(schlick_sky, 0.0f);
  }
}
#endif

// Where the results of gathers go.
typedef struct {
  __global float4* irradiance;
  __global float4* specular;
  __global float4* micro_buffer;
} MicroResults;

// Whether a lobe's micro-buffer is kept: the larger one of a result that is inspected.
bool is_inspected(const MicroPoint* point, const MicroSettings* settings, const uint* edges, uint lobe) {
  return (point->result == settings->inspect || point->result == settings->inspect_too) &&
         edges[lobe] >= edges[1u - lobe];
}

// One lobe of a gather, with a micro-buffer of edges[lobe]² pixels: builds Φ, draws, and sums up. half_value: of the
// lobe; eta: above 0, the specular lobe transmits; level: see gather_light().
void gather_lobe(const MicroForest* forest, const MicroNodeLight* node_light, const MicroSettings* settings,
                 const MicroPoint* point, const uint* edges, uint lobe, float half_width, float eta, float4 level,
                 float unit,
#if MICRO_GATHER_ENV
                 const Scene* scene, __global float4* sky,
#endif
                 MicroBuffer* buffer, MicroStatistics* counts, const MicroResults* results) {
  // Loosen the cut where that of the frame before had nothing to resolve.
  const bool flat = MICRO_ERROR_CUT && level.w < 0.0f;
  const float kappa = settings->kappa * (flat ? MICRO_FLAT_KAPPA : 1.0f);
  const uint kind = lobe == MICRO_LOBE_SPECULAR && eta > 0.0f ? MICRO_LOBE_REFRACTED : lobe;
  MicroWarp warp;
  make_micro_warp(kind, edges[lobe], half_width, eta, to_local(&point->basis, point->view), kappa, &warp);
#if MICRO_ERROR_CUT
  tolerate_error(forest, *settings, (lobe == MICRO_LOBE_DIFFUSE ? level.x : level.y) / unit, flat, &warp);
#endif
  draw_lobe(point, &warp, forest, *settings, buffer, counts);
  float3 schlick_sum;
  const float4 light = micro_light(&warp, point, buffer, node_light, &schlick_sum, counts);
  store_light(lobe, point->result, unit, light, schlick_sum, results->irradiance, results->specular);
#if MICRO_GATHER_ENV
  store_sky(scene, &warp, point, buffer, lobe, sky);
#endif
  if (is_inspected(point, settings, edges, lobe))
    store_micro_buffer(&warp, point, buffer, node_light, unit, results->micro_buffer);
}

// The micro-rendering of Ritschel et al. 2009, section 3.2: one work-item builds the warp, cuts the hierarchy, casts
// the post-traversal list and sums up, for one gather. Results at the indices of the gathers, see MicroStatistics
// (micro_types.h); every gather overwrites those of its lobes. micro_buffer: of the result settings.inspect, rows of
// MICRO_SIZE pixels; of the larger lobe. levels: what the frames before have found.
__kernel void gather_light(__global const MicroTree* restrict trees, uint tree_count,
                           __global const uint4* restrict nodes, __global const half* restrict radiance,
                           __global const uint4* restrict clips, __global const float* restrict radiance_unit,
                           __global const MicroGather* restrict gathers, __global const uint* restrict gather_count,
                           const MicroSettings settings, __global float4* restrict irradiance,
                           __global float4* restrict specular, __global MicroStatistics* restrict statistics,
                           __global float4* restrict micro_buffer,
#if MICRO_LEVELS
                           __global const float4* restrict levels,
#endif
#if MICRO_GATHER_ENV
                           LUCARIUM_SCENE_PARAMETERS __global float4* restrict sky,
#endif
#if MICRO_DYNAMIC
                           __global const MicroNodeChoice* restrict choices,
                           __global const MicroLeafLight* restrict leaf_lights,
                           __global const MicroLeafLobe* restrict leaf_lobes,
#endif
                           uint slice_base) {
  const uint i = settings.first + slice_base + get_global_id(0);
  if (i >= gather_count[0]) return;
  const float unit = radiance_unit[0];
  const MicroForest forest = {trees, tree_count, nodes, radiance, clips};
#if MICRO_DYNAMIC
  const MicroNodeLight node_light = {radiance, choices, leaf_lights, leaf_lobes, 1.0f / unit};
#else
  const MicroNodeLight node_light = {radiance};
#endif
  const MicroResults results = {irradiance, specular, micro_buffer};
  // Find the gather's frame, turned at random against banding (section 2.3), and the micro-buffer of each lobe.
  const MicroPoint point = make_micro_point(gathers + i, settings.seed);
  const uint lobes = gathers[i].lobes;
  const uint edges[2] = {min(lobes & 255u, (uint)MICRO_SIZE), min((lobes >> 8) & 255u, (uint)MICRO_SIZE)};
  MicroStatistics counts = {0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u};
#if MICRO_LEVELS
  const float4 level = levels[point.result];
  if (edges[MICRO_LOBE_SPECULAR] == 0u)
    specular[2u * point.result] = (float4)(0.0f);  // of a frame that saw another surface
#else
  const float4 level = (float4)(0.0f);
#endif
  MicroBuffer buffer;
#if MICRO_GATHER_ENV
  LUCARIUM_SCENE_BIND(scene);
#endif
  for (uint lobe = MICRO_LOBE_DIFFUSE; lobe <= MICRO_LOBE_SPECULAR; ++lobe) {
    if (edges[lobe] == 0u) continue;
    gather_lobe(&forest, &node_light, &settings, &point, edges, lobe, half_value(lobes >> 16), gathers[i].eta, level,
                unit,
#if MICRO_GATHER_ENV
                &scene, sky,
#endif
                &buffer, &counts, &results);
  }
  statistics[point.result] = counts;
}
