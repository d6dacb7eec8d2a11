// SPDX-License-Identifier: Apache-2.0
// Jacobi iteration: the nodes of a cut gather irradiance, which is pushed to the leaves (Ritschel et al. 2009, section
// 4).
//
// The cut: nodes of one level of every tree, and where normals spread by more than `cone` nodes below them, since one
// irradiance does not fit surfaces that face different ways. It goes as many levels deeper as leave room for all its
// nodes.
#include "micro_rendering/tree/micro_node.clh"
#include "micro_rendering/tree/micro_surface.clh"

// Whether node i of a tree is split where levels allow.
bool is_bent(const global MicroTree* tree, const global uint4* heap, uint i, float cone) {
  return i < (1u << tree->depth) && unpack_node(heap[i]).cone > cone;
}

// The node behind subtree i in preorder; of the same or a higher level: a skip-pointer, from the number alone (Ritschel
// et al. 2009, section 2.1).
uint behind_subtree(uint i) {
  const uint next = i + 1u;
  return next >> (31u - clz(next & (0u - next)));
}

// Most levels for which the cut has no more than `most` nodes.
uint levels_that_fit(const global uint* totals, uint most) {
  uint deeper = 0u;
  while (deeper < MICRO_CUT_LEVELS && totals[deeper + 1u] <= most) ++deeper;
  return deeper;
}

// Work-item i: adds how many nodes the cut has below node 2^level + i of one tree, for 0 … MICRO_CUT_LEVELS levels
// more.
__kernel void mr_cut_totals(__global const MicroTree* restrict trees, const uint tree, const uint level,
                            const float cone, __global const uint4* restrict nodes, __global uint* restrict totals) {
  const uint root = (1u << level) + get_global_id(0);
  if (root >= (2u << level)) return;
  __global const MicroTree* t = trees + tree;
  __global const uint4* heap = nodes + t->first_node;
  uint counts[MICRO_CUT_LEVELS + 1u];
  for (uint k = 0; k <= MICRO_CUT_LEVELS; ++k) counts[k] = 0u;
  uint i = root;
  do {
    const uint below = 31u - clz(i) - level;
    const bool split = is_bent(t, heap, i, cone);
    // Limited to its level a node belongs to the cut, with more levels only where it stays whole.
    for (uint k = below; k <= (split ? below : MICRO_CUT_LEVELS); ++k) ++counts[k];
    i = split && below < MICRO_CUT_LEVELS ? 2u * i : behind_subtree(i);
  } while (31u - clz(i) > level);
  for (uint k = 0; k <= MICRO_CUT_LEVELS; ++k) atomic_add(totals + k, counts[k]);
}

// Work-item i: slots[first_slot + i] becomes the number of nodes of the cut below node 2^level + i.
__kernel void mr_cut_counts(__global const MicroTree* restrict trees, const uint tree, const uint level,
                            const float cone, const uint first_slot, const uint most,
                            __global const uint* restrict totals, __global const uint4* restrict nodes,
                            __global uint* restrict slots) {
  const uint root = (1u << level) + get_global_id(0);
  if (root >= (2u << level)) return;
  __global const MicroTree* t = trees + tree;
  __global const uint4* heap = nodes + t->first_node;
  const uint bottom = level + levels_that_fit(totals, most);
  uint count = 0u, i = root;
  do {
    const bool split = 31u - clz(i) < bottom && is_bent(t, heap, i, cone);
    count += !split;
    i = split ? 2u * i : behind_subtree(i);
  } while (31u - clz(i) > level);
  slots[first_slot + get_global_id(0)] = count;
}

// The gather of node i, at the leaf nearest to its centre; its leaves learn the slot.
MicroGather node_gather(const Scene* scene, const global MicroLeaf* leaves, const global MicroPatch* patches,
                        const global MicroTree* tree, const global uint4* heap, uint i, uint slot, uint micro_size,
                        global uint* leaf_slots) {
  const float3 center = unpack_node(heap[i]).center;
  const uint below = tree->depth - (31u - clz(i)), first = i << below,
             first_leaf = tree->first_node / 2u - (1u << tree->depth);
  uint nearest = first;
  float nearest2 = INFINITY;
  for (uint k = first; k < first + (1u << below); ++k) {
    const float3 d = unpack_node(heap[k]).center - center;
    const float d2 = dot(d, d);
    if (d2 < nearest2) nearest2 = d2, nearest = k;
    leaf_slots[first_leaf + k] = slot;
  }
  const MicroLeaf leaf = leaves[first_leaf + nearest];
  const Surface surface = leaf_surface(scene, leaf);
  MicroGather gather;
  gather.position = (float4)(surface.position, as_float(slot));
  gather.normal = pack_direction(surface.n_s);
  gather.geometric = pack_direction(surface.n_g);
  gather.view = gather.geometric;
  gather.lobes = micro_size;
  gather.hidden = MICRO_SIDE(patches[leaf_triangle(leaf)].sheet, !(leaf.triangle & MICRO_LEAF_BACK));
  gather.eta = 0.0f;
  return gather;
}

// Work-item i: the gathers of the cut below node 2^level + i, from slots[first_slot + i] on.
__kernel void mr_cut_gathers(LUCARIUM_SCENE_PARAMETERS __global const MicroLeaf* restrict leaves,
                             __global const MicroTree* restrict trees, const uint tree, const uint level,
                             const float cone, const uint first_slot, const uint most,
                             __global const uint* restrict totals, __global const uint* restrict slots,
                             const uint micro_size, __global const uint4* restrict nodes,
                             __global const MicroPatch* restrict patches, __global MicroGather* restrict gathers,
                             __global uint* restrict leaf_slots) {
  const uint root = (1u << level) + get_global_id(0);
  if (root >= (2u << level)) return;
  LUCARIUM_SCENE_BIND(scene);
  __global const MicroTree* t = trees + tree;
  __global const uint4* heap = nodes + t->first_node;
  const uint bottom = level + levels_that_fit(totals, most);
  uint slot = slots[first_slot + get_global_id(0)], i = root;
  do {
    const bool split = 31u - clz(i) < bottom && is_bent(t, heap, i, cone);
    if (!split) {
      gathers[slot] = node_gather(&scene, leaves, patches, t, heap, i, slot, micro_size, leaf_slots);
      ++slot;
    }
    i = split ? 2u * i : behind_subtree(i);
  } while (31u - clz(i) > level);
}

// The push step (Ritschel et al. 2009, section 4). Leaf i: direct light and what its node of the cut has gathered;
// irradiance and not radiance is pushed, so that each leaf keeps its own albedo.
__kernel void mr_push(const uint count, __global const uint* restrict leaf_slots,
                      __global const float4* restrict direct, __global const float4* restrict gathered,
                      __global float4* restrict irradiance) {
  const uint i = get_global_id(0);
  if (i < count) irradiance[i] = (float4)(direct[i].xyz + gathered[leaf_slots[i]].xyz, 0.0f);
}
