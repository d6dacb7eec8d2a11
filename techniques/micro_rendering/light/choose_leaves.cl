// SPDX-License-Identifier: Apache-2.0
// node_shading=dynamic: the glossy lobes of the leaves, and the leaf that each node stands for.
#include "lucarium/random.clh"
#include "micro_rendering/tree/micro_dynamic.clh"
#include "micro_rendering/tree/micro_surface.clh"

// Lobes of the leaves.
__kernel void store_leaf_lobes(LUCARIUM_SCENE_PARAMETERS __global const MicroLeaf* restrict leaves, uint count,
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

// Work-item i: leaf i of one tree takes the light that has arrived, and chooses itself.
__kernel void choose_leaves(__global const MicroLeafLight* restrict arriving, __global const MicroTree* restrict trees,
                            uint tree, uint count, __global MicroLeafLight* restrict leaf_lights,
                            __global MicroNodeChoice* restrict choices) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  MicroNodeChoice choice;
  choice.leaf = trees[tree].first_node / 2u + i;
  const MicroLeafLight light = arriving[choice.leaf];
  leaf_lights[choice.leaf] = light;
  choice.luminance = light.direction.w;
  choices[trees[tree].first_node + count + i] = choice;
}

// Inner nodes of levels [top, bottom), as pull_radiance, whose weights are in extremes.
__kernel void pull_choices(__global const MicroTree* restrict trees, uint tree, uint top, uint bottom, uint seed,
                           __global const float4* restrict extremes, __global MicroNodeChoice* restrict choices) {
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
