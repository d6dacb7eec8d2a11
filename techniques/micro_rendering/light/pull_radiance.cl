// SPDX-License-Identifier: Apache-2.0
// Radiance of the leaves, and its means in the inner nodes (Ritschel et al. 2009, section 4; radiance is kept beside
// the nodes, section 3.1).
#include "micro_rendering/tree/micro_node.clh"

// Radiance of leaf i without its own emission, (albedo / pi) E [cd/m²]. For the brightest channel's maximum.
__kernel void find_leaf_brightness(__global const float4* restrict irradiance,
                                   __global const half* restrict leaf_albedo, uint count,
                                   __global float* restrict brightness) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  brightness[i] = max_component(vload_half4(i, leaf_albedo).xyz * irradiance[i].xyz) * M_1_PI_F;
}

// The power of two that brings the brightest leaf to 2^14 ± 1 and so everything else into the range of halfs.
float radiance_unit_of(float brightest) {
  if (!(brightest > 0.0f) || isinf(brightest)) return 1.0f;
  return exp2(clamp(ceil(log2(brightest)), -100.0f, 100.0f) - 14.0f);
}

// Once for all leaves: logarithm and exponential take longer than all else that a leaf needs.
__kernel void store_radiance_unit(__global const float* restrict brightest, __global float* restrict radiance_unit) {
  radiance_unit[0] = radiance_unit_of(brightest[0]);
}

// Work-item i: leaf i of one tree. extremes, per node: x lowest, y highest brightest channel [units], z weight (area).
__kernel void store_radiance(__global const float4* restrict irradiance, __global const half* restrict leaf_albedo,
                             __global const float* restrict radiance_unit, __global const MicroTree* restrict trees,
                             uint tree, __global const uint4* restrict nodes, uint count,
                             __global half* restrict radiance, __global float4* restrict extremes) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const float unit = radiance_unit[0];
  const uint leaf = trees[tree].first_node / 2u + i, node = trees[tree].first_node + count + i;
  const float3 value = vload_half4(leaf, leaf_albedo).xyz * irradiance[leaf].xyz * (M_1_PI_F / unit);
  const float highest = max_component(value), radius = unpack_node(nodes[node]).radius;
  vstore_half4((float4)(value, 0.0f), node, radiance);
  extremes[node] = (float4)(highest, highest, fmax(radius * radius, FLT_MIN), 0.0f);
}

// The pull step of push-pull (Ritschel et al. 2009, section 4). Inner nodes of levels [top, bottom), as refit_nodes:
// means by area, and the range of what lies below.
__kernel void pull_radiance(__global const MicroTree* restrict trees, uint tree, uint top, uint bottom,
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
