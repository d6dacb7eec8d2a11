// SPDX-License-Identifier: Apache-2.0
// Closest and any hit over a sparse octree: rays are traced to its leaves (Hu et al. 2014, section 5.2, table 1). Of
// those that a ray enters, the first one whose triangle counts is hit (compared_hit()). Descent with the nodes of the
// path kept, so that a step begins at the lowest node that both voxels share (Laine and Karras, "Efficient Sparse Voxel
// Octrees", 2010).
#include "voxel_abuffer/compared/compared_ray.clh"
#include "voxel_abuffer/compared/voxel_keys.clh"
#include "voxel_abuffer/shared/octree_layout.h"

typedef struct ComparedContext {
  AbufferContext walk;
  const Scene* scene;
  uint levels;                  // of nodes with eight children: the root has 1 << (levels + 2) voxels along an edge
  __global const uint2* nodes;  // x: first child, y: a bit for each child that is there; the root first
  __global const ulong* brick_masks;  // the two lowest levels: a bit per leaf
  __global const uint* brick_first;   // leaves of the bricks before
  __global const uint* leaves;        // triangle of a leaf
} ComparedContext;

#define COMPARED_PARAMETERS                                                                      \
  uint levels, __global const uint2 *compared_nodes, __global const ulong *compared_brick_masks, \
      __global const uint *compared_brick_first, __global const uint *compared_leaves
#define COMPARED_BIND(context)                \
  context.levels = levels;                    \
  context.nodes = compared_nodes;             \
  context.brick_masks = compared_brick_masks; \
  context.brick_first = compared_brick_first; \
  context.leaves = compared_leaves

// Bit `bit` of the three coordinates, as the number of a child.
static uint compared_child(uint4 voxel, uint bit) {
  return (voxel.x >> bit & 1u) | (voxel.y >> bit & 1u) << 1 | (voxel.z >> bit & 1u) << 2;
}

// Nodes of the path from the root to a voxel; path[levels] is a brick.
typedef struct ComparedPath {
  uint node[OCTREE_MAX_LEVELS + 1];
  uint depth;  // the last that is known
} ComparedPath;

// Follows the path on to the voxel. Returns the edge of the empty cube in which that lies, 0 for a leaf.
static uint compared_descend(const ComparedContext* context, ComparedPath* path, uint4 voxel) {
  for (; path->depth < context->levels; ++path->depth) {
    const uint bit = context->levels + 1u - path->depth;
    const uint2 node = context->nodes[path->node[path->depth]];
    const uint child = compared_child(voxel, bit);
    if (!(node.y >> child & 1u)) return 1u << bit;
    path->node[path->depth + 1u] = node.x + (uint)popcount(node.y & ((1u << child) - 1u));
  }
  const ulong mask = context->brick_masks[path->node[context->levels]];
  const uint within = compared_within(voxel);
  if (!(mask >> (within & 56u) & 255ul)) return 2u;
  return mask >> within & 1ul ? 0u : 1u;
}

static bool compared_trace(const ComparedContext* context, AbufferRay* r, const Ray* ray, const Ray* moved, Hit* hit,
                           const bool any) {
  const AbufferGrid* grid = &context->walk.grid;
  ComparedPath path;
  path.node[0] = 0u;
  path.depth = 0u;
  for (;;) {
    // Descend to the leaf, or to the largest empty cube around the voxel.
    const uint4 voxel = as_uint4(r->voxel);
    const uint empty = compared_descend(context, &path, voxel);
    const int edge = (int)max(empty, 1u);
    int4 axes;
    const float leaves = abuffer_leave(grid, r, edge, &axes);
    // Hit the leaf.
    if (!empty) {
#ifndef BVH_ALPHA
      if (any) return true;
#endif
      const uint brick = path.node[context->levels];
      const uint leaf =
          context->brick_first[brick] + compared_rank(context->brick_masks[brick], compared_within(voxel));
      const uint triangle = context->leaves[leaf];
      if (compared_hit(context->scene, grid, ray, moved, triangle, r->distance, leaves, hit, any)) return true;
    }
    if (leaves >= r->end || !abuffer_enter(grid, r, edge, axes, leaves)) return false;
    // Go back up to the lowest node that holds both voxels.
    const uint4 differ = voxel ^ as_uint4(r->voxel);
    const uint highest = 31u - clz(differ.x | differ.y | differ.z);
    path.depth = highest > context->levels + 1u ? 0u : min(path.depth, context->levels + 1u - highest);
  }
}

#include "voxel_abuffer/compared/leaf_rays.clh"
