// SPDX-License-Identifier: Apache-2.0
// How a binary hierarchy becomes a wide one.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "lucarium/services/bvh/build.h"

namespace lucarium {

/// Chooses which binary nodes survive as wide nodes, leaves and children, by dynamic programming over "the cheapest way
/// to represent a subtree by at most j roots" (Ylitie, Karras, Laine, "Efficient Incoherent Ray Traversal on GPUs
/// Through Compressed Wide BVHs", 2017, section 3.1, equations 2 to 4), with equal costs for a node and a leaf block.
class CollapsePlan {
 public:
  static constexpr int max_width = 16;
  using Subtree = BinaryBvh::Subtree;

  /// `binary` must stay. What it has not divided fits into leaves.
  CollapsePlan(const BinaryBvh& binary, int width, int leaf_size, unsigned threads);

  /// Subtrees as which a wide node's children represent this one, in their order.
  struct Roots {
    std::array<Subtree, max_width> of;
    uint32_t count = 0;
  };
  Roots children(const Subtree& subtree) const;
  bool is_leaf(const Subtree& subtree) const {
    return subtree.count <= binary_.undivided || choices_[subtree.node].roots_left[1];
  }
  /// Expected number of nodes and leaf blocks of a subtree that a ray visits which enters it.
  float visits(const Subtree& subtree) const {
    return subtree.count <= binary_.undivided ? 1 : choices_[subtree.node].visits;
  }

 private:
  /// [j − 1]: with at most j roots; infinite where there are fewer triangles than j.
  using Costs = std::array<float, max_width>;

  struct Choice {
    /// [j] for j ≥ 2: how many of j roots go to the left subtree, 0: j − 1 roots are as good.
    /// [1]: 1 for a leaf block.
    /// [0]: how many of `width` roots go left when the node itself becomes a wide node.
    std::array<uint8_t, max_width> roots_left;
    float visits;
  };

  void plan(const Subtree& subtree, Costs& costs);
  void choose(const Subtree& subtree, const Costs& left, const Costs& right, Costs& costs);
  void collect(const Subtree& subtree, uint32_t roots, Roots& out) const;

  const BinaryBvh& binary_;
  uint32_t width_, leaf_size_;
  LargeArray<Choice> choices_;
};

}  // namespace lucarium
