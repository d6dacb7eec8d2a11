// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/bvh/wide.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "lucarium/shared/ray.h"

namespace lucarium {

void WideBvh::set_child_box(uint32_t node_index, int slot, const Bounds& box) {
  uint32_t* words = node(node_index) + slot;
  for (int axis = 0; axis < 3; ++axis) {
    words[axis * width_] = std::bit_cast<uint32_t>(box.min[axis]);
    words[LUCARIUM_BVH_UPPER(width_) + axis * width_] = std::bit_cast<uint32_t>(box.max[axis]);
  }
}

Bounds WideBvh::fit_block(uint32_t* words, std::span<const Vertex> vertices, std::span<const Triangle> triangles) {
  const uint32_t* ids = words + LUCARIUM_BVH_BLOCK_TRIANGLES(leaf_size_);
  Bounds bounds;
  for (int slot = 0; slot < leaf_size_; ++slot) {
    Bounds box;
    const bool usable = ids[slot] != LUCARIUM_NO_HIT && bound_triangle(vertices, triangles[ids[slot]], box);
    if (usable) bounds.add(box);
    if (!usable && ids[slot] != LUCARIUM_NO_HIT) ++dead_count_;
    const uint32_t corners[3] = {usable ? triangles[ids[slot]].v0 : 0, usable ? triangles[ids[slot]].v1 : 0,
                                 usable ? triangles[ids[slot]].v2 : 0};
    for (int corner = 0; corner < 3; ++corner) {
      const float4 p = usable ? vertices[corners[corner]].position : float4();
      const float coordinates[3] = {p.x, p.y, p.z};
      for (int axis = 0; axis < 3; ++axis)
        words[(3 * corner + axis) * leaf_size_ + slot] = std::bit_cast<uint32_t>(coordinates[axis]);
    }
  }
  return bounds;
}

void WideBvh::fit(std::span<const Vertex> vertices, std::span<const Triangle> triangles) {
  dead_count_ = 0;
  std::vector<Bounds> boxes(node_count_);
  double cost = 0;
  // Children follow their parents, so that backwards every child is ready before its parent needs it.
  for (uint32_t index = node_count_; index-- > 0;) {
    for (int slot = 0; slot < width_; ++slot) {
      const uint32_t reference = node(index)[LUCARIUM_BVH_NODE_REFERENCES(width_) + slot];
      Bounds box;
      if (reference != no_child)
        box = reference & LUCARIUM_BVH_LEAF
                  ? fit_block(&blocks_[reference & ~LUCARIUM_BVH_LEAF], vertices, triangles)
                  : boxes[(reference - LUCARIUM_BVH_HEADER_WORDS) / LUCARIUM_BVH_NODE_WORDS(width_)];
      set_child_box(index, slot, box);
      boxes[index].add(box);
      cost += static_cast<double>(box.half_area());
    }
  }
  bounds_ = boxes[0];
  const double root_area = static_cast<double>(bounds_.half_area());
  sah_cost_ = root_area > 0 ? 1 + cost / root_area : 1;
}

size_t WideBvh::estimate_bytes(uint64_t triangles, int width, int leaf_size) {
  // Blocks a third full and nodes half: for 16 and 8, 144 bytes per triangle where scenes took 74 to 79 and triangles
  // of very different sizes without order 115; an upper estimate, not a bound.
  const uint64_t blocks = 3 * triangles / static_cast<uint64_t>(leaf_size) + 1;
  const uint64_t nodes = 2 * blocks / static_cast<uint64_t>(width) + 1;
  return 4 * (blocks * LUCARIUM_BVH_BLOCK_WORDS(static_cast<uint64_t>(leaf_size)) +
              nodes * LUCARIUM_BVH_NODE_WORDS(static_cast<uint64_t>(width)) + LUCARIUM_BVH_HEADER_WORDS);
}

}  // namespace lucarium
