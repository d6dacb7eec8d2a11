// SPDX-License-Identifier: Apache-2.0
// Closest and any hit of a buffer of rays. A work-item owns BVH_CHUNK consecutive rays (CPU-like devices: local size 1)
// or one (GPU-like ones); the number of rays is read from a device counter.
#ifndef BVH_WIDTH
#define BVH_WIDTH 16
#define BVH_LEAF 8
#define BVH_STACK 256
#define BVH_CHUNK 256
#endif
#include "lucarium/services/bvh_traverse.clh"

static __global const float* bvh_node(__global const float* nodes, uint index) {
  return nodes + LUCARIUM_BVH_HEADER_WORDS + index * LUCARIUM_BVH_NODE_WORDS((uint)BVH_WIDTH);
}

static __global const float* bvh_block(__global const float* blocks, uint reference) {
  return blocks + (reference & ~LUCARIUM_BVH_LEAF) * LUCARIUM_BVH_BLOCK_WORDS((uint)BVH_LEAF);
}

// Keeps the nearest hit of the block's accepted triangles; equal distances go to the lower index.
static void bvh_keep_nearest(__global const float* block, uint mask, BvhLeafLanes distance, BvhLeafLanes u,
                             BvhLeafLanes v, Hit* best) {
  float distances[BVH_LEAF], us[BVH_LEAF], vs[BVH_LEAF];
  BVH_STORE_LEAF(distance, distances);
  BVH_STORE_LEAF(u, us);
  BVH_STORE_LEAF(v, vs);
  __global const uint* triangles = (__global const uint*)(block + BVH_TRIANGLES);
  for (; mask; mask &= mask - 1u) {
    const uint lane = bvh_lowest_bit(mask);
    const uint triangle = triangles[lane];
    if (distances[lane] < best->distance || (distances[lane] == best->distance && triangle < best->triangle)) {
      best->distance = distances[lane];
      best->triangle = triangle;
      best->u = us[lane];
      best->v = vs[lane];
    }
  }
}

static Hit bvh_trace_closest(__global const float* nodes, __global const float* blocks, const Ray ray) {
  Hit best = {fmin(ray.direction.w, MAXFLOAT), LUCARIUM_NO_HIT, 0.0f, 0.0f};
  BvhRay r;
  uint stack[BVH_STACK];
  float entry_stack[BVH_STACK];
  uint waiting = 0u;
  if (bvh_prepare(ray, nodes[LUCARIUM_BVH_HEADER_EXTENT], &r)) {
    uint reference = 0u;
    for (;;) {
      if (reference & LUCARIUM_BVH_LEAF) {
        // Leaf: test its triangles at once.
        __global const float* block = bvh_block(blocks, reference);
        BvhLeafLanes distance, u, v;
        const uint mask = bvh_hit_triangles(block, &r, best.distance, &distance, &u, &v);
        if (mask) bvh_keep_nearest(block, mask, distance, u, v, &best);
      } else {
        // Node: go on with the nearest child, push the others farthest first.
        __global const float* node = bvh_node(nodes, reference);
        BvhBoxLanes entry;
        uint mask = bvh_cross_children(node, &r, best.distance, &entry);
        if (mask) {
          __global const uint* references = (__global const uint*)(node + BVH_REFERENCES);
          uint lane = bvh_lowest_bit(mask);
          mask &= mask - 1u;
          reference = references[lane];
          if (!mask) continue;
          float entries[BVH_WIDTH];
          BVH_STORE_BOXES(entry, entries);
          float nearest = entries[lane];
          const uint base = waiting;
          for (; mask; mask &= mask - 1u) {
            lane = bvh_lowest_bit(mask);
            uint other = references[lane];
            float other_entry = entries[lane];
            if (other_entry < nearest) {
              const uint swap = reference;
              const float swap_entry = nearest;
              reference = other, nearest = other_entry;
              other = swap, other_entry = swap_entry;
            }
            uint slot = waiting++;
            for (; slot > base && entry_stack[slot - 1u] < other_entry; --slot) {
              stack[slot] = stack[slot - 1u];
              entry_stack[slot] = entry_stack[slot - 1u];
            }
            stack[slot] = other;
            entry_stack[slot] = other_entry;
          }
          continue;
        }
      }
      // Pop what may still hold something nearer.
      while (waiting > 0u && entry_stack[waiting - 1u] > best.distance) --waiting;
      if (waiting == 0u) break;
      reference = stack[--waiting];
    }
  }
  if (best.triangle == LUCARIUM_NO_HIT) best.distance = INFINITY;
  return best;
}

static uint bvh_trace_any(__global const float* nodes, __global const float* blocks, const Ray ray) {
  BvhRay r;
  uint stack[BVH_STACK];
  uint waiting = 0u;
  if (!bvh_prepare(ray, nodes[LUCARIUM_BVH_HEADER_EXTENT], &r)) return 0u;
  const float limit = fmin(ray.direction.w, MAXFLOAT);
  uint reference = 0u;
  for (;;) {
    if (reference & LUCARIUM_BVH_LEAF) {
      BvhLeafLanes distance, u, v;
      if (bvh_hit_triangles(bvh_block(blocks, reference), &r, limit, &distance, &u, &v)) return 1u;
    } else {
      __global const float* node = bvh_node(nodes, reference);
      BvhBoxLanes entry;
      uint mask = bvh_cross_children(node, &r, limit, &entry);
      __global const uint* references = (__global const uint*)(node + BVH_REFERENCES);
      for (; mask; mask &= mask - 1u) stack[waiting++] = references[bvh_lowest_bit(mask)];
    }
    if (waiting == 0u) return 0u;
    reference = stack[--waiting];
  }
}

__kernel void bvh_closest(__global const Ray* rays, __global Hit* hits, __global const uint* counter,
                          uint counter_index, uint capacity, uint slice_base, __global const float* bvh_nodes,
                          __global const float* bvh_blocks) {
  const uint count = min(counter[counter_index], capacity);
  const uint first = ((uint)get_global_id(0) + slice_base) * BVH_CHUNK;
  const uint end = min(first + BVH_CHUNK, count);
  for (uint i = first; i < end; ++i) hits[i] = bvh_trace_closest(bvh_nodes, bvh_blocks, rays[i]);
}

__kernel void bvh_any(__global const Ray* rays, __global uint* occluded, __global const uint* counter,
                      uint counter_index, uint capacity, uint slice_base, __global const float* bvh_nodes,
                      __global const float* bvh_blocks) {
  const uint count = min(counter[counter_index], capacity);
  const uint first = ((uint)get_global_id(0) + slice_base) * BVH_CHUNK;
  const uint end = min(first + BVH_CHUNK, count);
  for (uint i = first; i < end; ++i) occluded[i] = bvh_trace_any(bvh_nodes, bvh_blocks, rays[i]);
}
