// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "lucarium/services/bvh/build.h"
#include "lucarium/shared/bvh_layout.h"

namespace lucarium {

/// Wide hierarchy in the memory layout of kernels/lucarium/shared/bvh_layout.h. The topology (references and triangle
/// indices) is made once on construction; fit() brings boxes and vertices up to date and may be repeated when vertices
/// have moved.
class WideBvh {
 public:
  using Words = LargeArray<uint32_t>;
  static constexpr uint32_t no_child = 0xffffffffu;  ///< reference of an empty slot

  WideBvh() = default;
  /// What the binary hierarchy was made of; nothing where that were items with boxes, which have no vertices.
  struct Geometry {
    std::span<const Vertex> vertices;
    std::span<const Triangle> triangles;
  };
  /// `width` children per node, up to `leaf_size` triangles per leaf block, as `binary` was built for. An empty
  /// hierarchy gets a root without children.
  WideBvh(const BinaryBvh& binary, int width, int leaf_size, const Geometry& geometry, unsigned threads);
  /// Recomputes all boxes, leaf vertices and the cost.
  void fit(std::span<const Vertex> vertices, std::span<const Triangle> triangles);

  int width() const { return width_; }
  int leaf_size() const { return leaf_size_; }
  uint32_t node_count() const { return node_count_; }
  uint32_t block_count() const { return block_count_; }
  /// Most references that can wait on a traversal stack.
  uint32_t stack_size() const { return stack_size_; }
  /// Expected number of nodes and leaf blocks that a random line visits which crosses the root's box.
  double sah_cost() const { return sah_cost_; }
  /// Triangles in the leaves that nothing could hit at the last fit().
  uint32_t dead_count() const { return dead_count_; }
  const Bounds& bounds() const { return bounds_; }

  const Words& node_words() const { return nodes_; }
  const Words& block_words() const { return blocks_; }
  /// Moves the words out; counts, bounds and cost stay, but there is nothing left to fit.
  std::pair<Words, Words> take_words() { return {std::move(nodes_), std::move(blocks_)}; }
  /// Puts words back, as they were.
  void put_words(Words nodes, Words blocks) {
    nodes_ = std::move(nodes);
    blocks_ = std::move(blocks);
  }
  bool has_words() const { return !nodes_.empty(); }

  /// Upper estimate of the bytes of a hierarchy over this many triangles.
  static size_t estimate_bytes(uint64_t triangles, int width, int leaf_size);

 private:
  class Emission;
  size_t node_word(size_t index) const {
    return LUCARIUM_BVH_HEADER_WORDS + index * LUCARIUM_BVH_NODE_WORDS(static_cast<size_t>(width_));
  }
  uint32_t node_reference(size_t index) const { return static_cast<uint32_t>(node_word(index)); }
  uint32_t block_reference(size_t block) const { return LUCARIUM_BVH_LEAF | static_cast<uint32_t>(block_word(block)); }
  uint32_t* node(size_t index) { return &nodes_[node_word(index)]; }
  size_t block_word(size_t block) const { return block * LUCARIUM_BVH_BLOCK_WORDS(static_cast<size_t>(leaf_size_)); }
  Bounds fit_block(uint32_t* words, std::span<const Vertex> vertices, std::span<const Triangle> triangles);
  void set_child_box(uint32_t node_index, int slot, const Bounds& box);

  int width_ = 0, leaf_size_ = 0;
  uint32_t node_count_ = 0, block_count_ = 0, stack_size_ = 0, dead_count_ = 0;
  double sah_cost_ = 0;
  Bounds bounds_;
  Words nodes_, blocks_;
};

}  // namespace lucarium
