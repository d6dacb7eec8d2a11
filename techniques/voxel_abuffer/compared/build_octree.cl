// SPDX-License-Identifier: Apache-2.0
// Levels of a sparse octree from its bricks upwards: their Morton codes are sorted, so that the children of a node
// stand together. What Hu et al. 2014, section 5.2, compare with.
#include "lucarium/shared/dialect.h"

// Whether a new parent begins. codes: of `count[0]` nodes.
__kernel void octree_mark_parents(__global const uint* codes, __global const uint* count, uint capacity,
                                  __global uint* begins) {
  const uint i = get_global_id(0);
  if (i >= capacity) return;
  begins[i] = i < count[0] && (i == 0u || codes[i] >> 3 != codes[i - 1u] >> 3);
}

// starts: first child of each of `parent_count[0]` parents. `child_base`, `base`: where the nodes of the level below
// and of this one begin.
__kernel void octree_make_nodes(__global const uint* codes, __global const uint* count, __global const uint* starts,
                                __global const uint* parent_count, uint capacity, uint child_base, uint base,
                                __global uint* parent_codes, __global uint2* nodes) {
  const uint i = get_global_id(0), parents = parent_count[0];
  if (i >= min(parents, capacity)) return;
  const uint begin = starts[i], end = i + 1u < parents ? starts[i + 1u] : count[0];
  uint mask = 0u;
  for (uint k = begin; k < end; ++k) mask |= 1u << (codes[k] & 7u);
  nodes[base + i] = (uint2)(child_base + begin, mask);
  parent_codes[i] = codes[begin] >> 3;
}
