// SPDX-License-Identifier: Apache-2.0
// Jacobi iteration: the gathers at the nodes of a cut (Ritschel et al. 2009, section 4).
//
// The cut: nodes of one level of every tree, and where normals spread by more than `cone` nodes below them, since one
// irradiance does not fit surfaces that face different ways. It goes as many levels deeper as leave room for all its
// nodes.
#include "micro_rendering/tree/micro_node.clh"
#include "micro_rendering/tree/micro_surface.clh"

// Whether node i of a tree is split where levels allow.
bool is_bent(const __global MicroTree* tree, const __global uint4* heap, uint i, float cone) {
  return i < (1u << tree->depth) && unpack_node(heap[i]).cone > cone;
}

// The node behind subtree i in preorder; of the same or a higher level: a skip-pointer, from the number alone (Ritschel
// et al. 2009, section 2.1).
uint behind_subtree(uint i) {
  const uint next = i + 1u;
  return next >> (31u - clz(next & (0u - next)));
}

// Most levels for which the cut has no more than `max_nodes` nodes.
uint levels_that_fit(const __global uint* totals, uint max_nodes) {
  uint deeper = 0u;
  while (deeper < MICRO_CUT_LEVELS && totals[deeper + 1u] <= max_nodes) ++deeper;
  return deeper;
}

// Work-item i: adds how many nodes the cut has below node 2^level + i of one tree, for 0 … MICRO_CUT_LEVELS levels
// more.
__kernel void sum_cut_sizes(__global const MicroTree* restrict trees, uint tree, uint level, float cone,
                            __global const uint4* restrict nodes, __global uint* restrict totals) {
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

// Work-item i: cut_results[first_root + i] becomes the number of nodes of the cut below node 2^level + i.
__kernel void count_cut_nodes(__global const MicroTree* restrict trees, uint tree, uint level, float cone,
                              uint first_root, uint max_nodes, __global const uint* restrict totals,
                              __global const uint4* restrict nodes, __global uint* restrict cut_results) {
  const uint root = (1u << level) + get_global_id(0);
  if (root >= (2u << level)) return;
  __global const MicroTree* t = trees + tree;
  __global const uint4* heap = nodes + t->first_node;
  const uint bottom = level + levels_that_fit(totals, max_nodes);
  uint count = 0u, i = root;
  do {
    const bool split = 31u - clz(i) < bottom && is_bent(t, heap, i, cone);
    count += !split;
    i = split ? 2u * i : behind_subtree(i);
  } while (31u - clz(i) > level);
  cut_results[first_root + get_global_id(0)] = count;
}

// The gather of node i, at the leaf nearest to its centre; its leaves learn the result.
MicroGather node_gather(const Scene* scene, const __global MicroLeaf* leaves,
                        const __global TriangleEdges* triangle_edges, const __global MicroTree* tree,
                        const __global uint4* heap, uint i, uint result, uint micro_size, __global uint* leaf_results) {
  const float3 center = unpack_node(heap[i]).center;
  const uint below = tree->depth - (31u - clz(i)), first = i << below,
             first_leaf = tree->first_node / 2u - (1u << tree->depth);
  uint nearest = first;
  float nearest2 = INFINITY;
  for (uint k = first; k < first + (1u << below); ++k) {
    const float3 d = unpack_node(heap[k]).center - center;
    const float d2 = dot(d, d);
    if (d2 < nearest2) nearest2 = d2, nearest = k;
    leaf_results[first_leaf + k] = result;
  }
  const MicroLeaf leaf = leaves[first_leaf + nearest];
  const Surface surface = leaf_surface(scene, leaf);
  MicroGather gather;
  gather.position = (float4)(surface.position, as_float(result));
  gather.normal = pack_direction(surface.n_s);
  gather.geometric = pack_direction(surface.n_g);
  gather.view = gather.geometric;
  gather.lobes = micro_size;
  gather.hidden = MICRO_SIDE(triangle_edges[leaf_triangle(leaf)].sheet, !(leaf.triangle & MICRO_LEAF_BACK));
  gather.eta = 0.0f;
  return gather;
}

// Work-item i: the gathers of the cut below node 2^level + i, from cut_results[first_root + i] on.
__kernel void list_cut_gathers(LUCARIUM_SCENE_PARAMETERS __global const MicroLeaf* restrict leaves,
                               __global const MicroTree* restrict trees, uint tree, uint level, float cone,
                               uint first_root, uint max_nodes, __global const uint* restrict totals,
                               __global const uint* restrict cut_results, uint micro_size,
                               __global const uint4* restrict nodes,
                               __global const TriangleEdges* restrict triangle_edges,
                               __global MicroGather* restrict gathers, __global uint* restrict leaf_results) {
  const uint root = (1u << level) + get_global_id(0);
  if (root >= (2u << level)) return;
  LUCARIUM_SCENE_BIND(scene);
  __global const MicroTree* t = trees + tree;
  __global const uint4* heap = nodes + t->first_node;
  const uint bottom = level + levels_that_fit(totals, max_nodes);
  uint result = cut_results[first_root + get_global_id(0)], i = root;
  do {
    const bool split = 31u - clz(i) < bottom && is_bent(t, heap, i, cone);
    if (!split) {
      gathers[result] = node_gather(&scene, leaves, triangle_edges, t, heap, i, result, micro_size, leaf_results);
      ++result;
    }
    i = split ? 2u * i : behind_subtree(i);
  } while (31u - clz(i) > level);
}
