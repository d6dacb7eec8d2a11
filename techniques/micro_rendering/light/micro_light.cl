// SPDX-License-Identifier: Apache-2.0
// Light at the leaves, and its means in the inner nodes (Ritschel et al. 2009, section 4; radiance is kept beside the
// nodes, section 3.1).
#include "lucarium/random.clh"
#include "micro_rendering/tree/micro_node.clh"
#include "micro_rendering/tree/micro_surface.clh"

#ifndef MICRO_DYNAMIC
#define MICRO_DYNAMIC 0  // 1: glossy lobes of nodes, see micro_dynamic.clh
#endif
#if MICRO_DYNAMIC
#include "micro_rendering/tree/micro_dynamic.clh"
#endif

#if MICRO_DYNAMIC
// Lobes of the leaves.
__kernel void mr_leaf_lobes(LUCARIUM_SCENE_PARAMETERS __global const MicroLeaf* restrict leaves, const uint count,
                            __global MicroLeafLobe* restrict leaf_lobes) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  LUCARIUM_SCENE_BIND(scene);
  const Surface surface = leaf_surface(&scene, leaves[i]);
  const Bsdf bsdf = make_bsdf(&scene, &surface, 0u);
  MicroLeafLobe lobe;
  lobe.normal = pack_direction(surface.n_s);
  vstore_half4((float4)(bsdf.f0, bsdf.f90), 0, (half*)lobe.fresnel);
  lobe.alpha = bsdf.p_reflect > 0.0f ? bsdf.alpha : 0.0f;
  leaf_lobes[i] = lobe;
}

// Work-item i: leaf i of one tree chooses itself.
__kernel void mr_choose_leaves(__global const MicroLeafLight* restrict leaf_lights,
                               __global const MicroTree* restrict trees, const uint tree, const uint count,
                               __global MicroNodeChoice* restrict choices) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  MicroNodeChoice choice;
  choice.leaf = trees[tree].first_node / 2u + i;
  choice.luminance = leaf_lights[choice.leaf].direction.w;
  choices[trees[tree].first_node + count + i] = choice;
}

// Inner nodes of levels [top, bottom), as mr_pull, whose weights are in extremes.
__kernel void mr_pull_choices(__global const MicroTree* restrict trees, const uint tree, const uint top,
                              const uint bottom, const uint seed, __global const float4* restrict extremes,
                              __global MicroNodeChoice* restrict choices) {
  const uint w = get_global_id(0);
  if (w >= (1u << top)) return;
  const uint base = trees[tree].first_node;
  for (uint level = bottom; level-- > top;) {
    const uint first = ((1u << top) + w) << (level - top), end = first + (1u << (level - top));
    for (uint i = first; i < end; ++i) {
      const uint a = base + 2u * i, b = a + 1u;
      const float share_a = extremes[a].z * choices[a].luminance, sum = share_a + extremes[b].z * choices[b].luminance;
      MicroNodeChoice choice;
      choice.leaf = uint_to_unit(hash_uint2(base + i, seed)) * sum < share_a ? choices[a].leaf : choices[b].leaf;
      choice.luminance = sum / (extremes[a].z + extremes[b].z);
      choices[base + i] = choice;
    }
  }
}
#endif

// Radiance of leaf i without its own emission, (albedo / pi) E [cd/m²]. For the brightest channel's maximum.
__kernel void mr_leaf_brightness(__global const float4* restrict irradiance, __global const half* restrict leaf_albedo,
                                 const uint count, __global float* restrict brightness) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  brightness[i] = max_component(vload_half4(i, leaf_albedo).xyz * irradiance[i].xyz) * M_1_PI_F;
}

// The power of two that brings the brightest leaf to 2^14 ± 1 and so everything else into the range of halfs.
float radiance_unit_of(float brightest) {
  if (!(brightest > 0.0f) || isinf(brightest)) return 1.0f;
  return exp2(clamp(ceil(log2(brightest)), -100.0f, 100.0f) - 14.0f);
}

// Work-item i: leaf i of one tree. extremes, per node: x lowest, y highest brightest channel [units], z weight (area).
__kernel void mr_store_radiance(__global const float4* restrict irradiance, __global const half* restrict leaf_albedo,
                                __global const float* restrict brightest, __global const MicroTree* restrict trees,
                                const uint tree, __global const uint4* restrict nodes, const uint count,
                                __global half* restrict radiance, __global float4* restrict extremes,
                                __global float* restrict radiance_unit) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const float unit = radiance_unit_of(brightest[0]);
  if (i == 0u) radiance_unit[0] = unit;
  const uint leaf = trees[tree].first_node / 2u + i, node = trees[tree].first_node + count + i;
  const float3 value = vload_half4(leaf, leaf_albedo).xyz * irradiance[leaf].xyz * (M_1_PI_F / unit);
  const float highest = max_component(value), radius = unpack_node(nodes[node]).radius;
  vstore_half4((float4)(value, 0.0f), node, radiance);
  extremes[node] = (float4)(highest, highest, fmax(radius * radius, FLT_MIN), 0.0f);
}

// The pull step of push-pull (Ritschel et al. 2009, section 4). Inner nodes of levels [top, bottom), as mr_refit: means
// by area, and the range of what lies below.
__kernel void mr_pull(__global const MicroTree* restrict trees, const uint tree, const uint top, const uint bottom,
                      __global half* restrict radiance, __global float4* restrict extremes) {
  const uint w = get_global_id(0);
  if (w >= (1u << top)) return;
  const uint base = trees[tree].first_node;
  for (uint level = bottom; level-- > top;) {
    const uint first = ((1u << top) + w) << (level - top), end = first + (1u << (level - top));
    for (uint i = first; i < end; ++i) {
      const uint a = base + 2u * i, b = a + 1u;
      const float4 ea = extremes[a], eb = extremes[b];
      const float weight = ea.z + eb.z;
      const float3 mean = (ea.z * vload_half4(a, radiance).xyz + eb.z * vload_half4(b, radiance).xyz) / weight;
      const float low = fmin(ea.x, eb.x), high = fmax(ea.y, eb.y);
      vstore_half4((float4)(mean, high - low), base + i, radiance);
      extremes[base + i] = (float4)(low, high, weight, 0.0f);
    }
  }
}
