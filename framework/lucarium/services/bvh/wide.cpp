// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/bvh/wide.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "lucarium/base/parallel.h"
#include "lucarium/shared/ray.h"

namespace lucarium {

void WideBvh::set_child_box(uint32_t node_index, int slot, const Bounds& box) {
  uint32_t* words = node(node_index) + slot;
  for (int axis = 0; axis < 3; ++axis) {
    words[axis * width_] = std::bit_cast<uint32_t>(box.min[axis]);
    words[LUCARIUM_BVH_UPPER(width_) + axis * width_] = std::bit_cast<uint32_t>(box.max[axis]);
  }
}

Bounds WideBvh::fit_block(uint32_t block, std::span<const Vertex> vertices, std::span<const Triangle> triangles) {
  uint32_t* words = &blocks_[block_word(block)];
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

void WideBvh::place_vertices(std::span<const Vertex> vertices, std::span<const Triangle> triangles, unsigned threads) {
  constexpr size_t run = 512;
  parallel_jobs((block_count_ + run - 1) / run, std::min(threads, block_count_ / 1024 + 1),
                [&] {
                  return [&](size_t job) {
                    const size_t end = std::min<size_t>(block_count_, (job + 1) * run);
                    for (size_t block = job * run; block < end; ++block) {
                      // What later blocks need lies anywhere.
                      if (block + 8 < end)
                        for_each_id(block + 8, [&](uint32_t id) { __builtin_prefetch(&triangles[id]); });
                      if (block + 4 < end)
                        for_each_id(block + 4, [&](uint32_t id) {
                          __builtin_prefetch(&vertices[triangles[id].v0]);
                          __builtin_prefetch(&vertices[triangles[id].v1]);
                          __builtin_prefetch(&vertices[triangles[id].v2]);
                        });
                      place_block(&blocks_[block_word(block)], vertices, triangles);
                    }
                  };
                },
                [](size_t) {});
}

void WideBvh::place_block(uint32_t* words, std::span<const Vertex> vertices,
                          std::span<const Triangle> triangles) const {
  const uint32_t* ids = words + LUCARIUM_BVH_BLOCK_TRIANGLES(leaf_size_);
  for (int slot = 0; slot < leaf_size_ && ids[slot] != LUCARIUM_NO_HIT; ++slot) {
    const Triangle& triangle = triangles[ids[slot]];
    uint32_t* word = words + slot;
    for (const uint32_t corner : {triangle.v0, triangle.v1, triangle.v2}) {
      const float4& p = vertices[corner].position;
      for (const float coordinate : {p.x, p.y, p.z}) *word = std::bit_cast<uint32_t>(coordinate), word += leaf_size_;
    }
  }
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
        box = reference & LUCARIUM_BVH_LEAF ? fit_block(reference & ~LUCARIUM_BVH_LEAF, vertices, triangles)
                                            : boxes[reference];
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
