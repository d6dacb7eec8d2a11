// SPDX-License-Identifier: Apache-2.0
// Construction of a wide hierarchy from a binary one. Declared in wide.h.
#include <algorithm>
#include <bit>
#include <cstring>

#include "lucarium/base/parallel.h"
#include "lucarium/services/bvh/arrange.h"
#include "lucarium/services/bvh/box_lanes.h"
#include "lucarium/services/bvh/collapse.h"
#include "lucarium/services/bvh/wide.h"
#include "lucarium/shared/ray.h"

namespace lucarium {

namespace {

constexpr uint32_t emitted_alone = 4096;  // triangles of a subtree that is left to one thread

}  // namespace

/// Collects wide nodes, parents before children and depth first, then writes them. Threads take subtrees; where those
/// go is known when all are collected.
class WideBvh::Emission {
 public:
  Emission(const BinaryBvh& binary, WideBvh& out, const Geometry& geometry, unsigned threads)
      : binary_(binary),
        out_(out),
        geometry_(geometry),
        threads_(threads),
        plan_(binary, out.width_, out.leaf_size_, threads) {}

  void run() {
    top_.nodes.reserve(256);
    collect_top(binary_.root());
    for_all_parts([&](Part& part) { part.stack = collect(part, part.root); });
    place(0);
    out_.stack_size_ = stack_of(0);
    out_.nodes_.resize(out_.node_word(out_.node_count_));
    out_.blocks_.resize(out_.block_word(out_.block_count_));
    std::fill_n(out_.nodes_.begin(), LUCARIUM_BVH_HEADER_WORDS, 0u);
    for_all_parts([&](Part& part) {
      write(part);
      write_blocks(part);
    });
    write(top_);
    sum_up();
  }

 private:
  using Subtree = BinaryBvh::Subtree;

  /// References of children are those of the part: to nodes of it or, in the top, `part_flag` and a part.
  struct Node {
    Slots slots;
    std::array<uint32_t, CollapsePlan::max_width> references;
    uint32_t index;  // in the whole hierarchy
  };
  static constexpr uint32_t part_flag = 0x40000000u;

  struct Part {
    Subtree root = {};
    std::vector<Node> nodes = {};
    std::vector<Subtree> leaves = {};
    uint32_t stack = 0;
    uint32_t first_node = 0, first_block = 0;
    double area = 0;  // of all children
  };

  template <class Work>
  void for_all_parts(const Work& work) {
    parallel_jobs(
        parts_.size(), std::min(threads_, binary_.root().count / emitted_alone + 1),
        [&] { return [&](size_t i) { work(parts_[i]); }; }, [](size_t) {});
  }

  Node& add_node(Part& part, const Subtree& subtree) {
    Node& node = part.nodes.emplace_back();
    node.slots = arrange(binary_, plan_, plan_.children(subtree), static_cast<uint32_t>(out_.width_));
    node.references.fill(no_child);
    return node;
  }

  void collect_top(const Subtree& subtree) {
    const size_t self = top_.nodes.size();
    const Slots slots = add_node(top_, subtree).slots;
    for (int slot = 0; slot < out_.width_; ++slot) {
      const Subtree& child = slots.of[slot];
      if (child.count == 0) continue;
      uint32_t& reference = top_.nodes[self].references[slot];
      if (plan_.is_leaf(child)) {
        reference = LUCARIUM_BVH_LEAF;
      } else if (child.count <= emitted_alone) {
        reference = part_flag | static_cast<uint32_t>(parts_.size());
        parts_.push_back({child});
      } else {
        reference = static_cast<uint32_t>(top_.nodes.size());
        collect_top(child);
      }
    }
  }

  /// Returns how many references may wait while the subtree is traversed.
  uint32_t collect(Part& part, const Subtree& subtree) {
    const size_t self = part.nodes.size();
    const Slots slots = add_node(part, subtree).slots;
    uint32_t count = 0, deepest = 0;
    for (int slot = 0; slot < out_.width_; ++slot) {
      const Subtree& child = slots.of[slot];
      if (child.count == 0) continue;
      ++count;
      const bool leaf = plan_.is_leaf(child);
      part.nodes[self].references[slot] = leaf ? LUCARIUM_BVH_LEAF | static_cast<uint32_t>(part.leaves.size())
                                               : static_cast<uint32_t>(part.nodes.size());
      if (leaf)
        part.leaves.push_back(child);
      else
        deepest = std::max(deepest, collect(part, child));
    }
    return count + deepest;
  }

  /// Gives a node of the top, and what is below, its place.
  void place(uint32_t index) {
    Node& node = top_.nodes[index];
    node.index = out_.node_count_++;
    for (uint32_t& reference : node.references) {
      if (reference == no_child) continue;
      if (reference & LUCARIUM_BVH_LEAF) {
        reference |= out_.block_count_++;
      } else if (reference & part_flag) {
        Part& part = parts_[reference & ~part_flag];
        part.first_node = out_.node_count_;
        part.first_block = out_.block_count_;
        out_.node_count_ += static_cast<uint32_t>(part.nodes.size());
        out_.block_count_ += static_cast<uint32_t>(part.leaves.size());
      } else {
        place(reference);
      }
    }
  }

  uint32_t stack_of(uint32_t index) const {
    uint32_t count = 0, deepest = 0;
    for (const uint32_t reference : top_.nodes[index].references) {
      count += reference != no_child;
      if (reference & LUCARIUM_BVH_LEAF) continue;
      deepest = std::max(deepest, reference & part_flag ? parts_[reference & ~part_flag].stack : stack_of(reference));
    }
    return count + deepest;
  }

  void write(Part& part) {
    const bool top = &part == &top_;
    for (size_t i = 0; i < part.nodes.size(); ++i) {
      const Node& node = part.nodes[i];
      const uint32_t index = top ? node.index : part.first_node + static_cast<uint32_t>(i);
      uint32_t* const words = out_.node(index);
      const auto width = static_cast<uint32_t>(out_.width_);
      std::fill_n(words + LUCARIUM_BVH_NODE_ORDER(width), width, 0u);
      words[LUCARIUM_BVH_NODE_ORDER(width)] = node.slots.order;
      for (uint32_t slot = 0; slot < width; ++slot) {
        const Bounds box = child_box(node.slots.of[slot]);
        out_.set_child_box(index, static_cast<int>(slot), box);
        part.area += static_cast<double>(box.half_area());
        uint32_t reference = node.references[slot];
        if (reference != no_child) {
          if (reference & LUCARIUM_BVH_LEAF) {
            if (top) write_block(reference & ~LUCARIUM_BVH_LEAF, node.slots.of[slot]);
            reference = out_.block_reference(part.first_block + (reference & ~LUCARIUM_BVH_LEAF));
          } else if (!top) {
            reference = out_.node_reference(part.first_node + reference);
          } else {
            reference = out_.node_reference(reference & part_flag ? parts_[reference & ~part_flag].first_node
                                                                  : top_.nodes[reference].index);
          }
        }
        words[LUCARIUM_BVH_NODE_REFERENCES(width) + slot] = reference;
      }
    }
  }

  Bounds child_box(const Subtree& child) const {
    if (child.count == 0) return {};
    return binary_.box(child).box();
  }

  void write_blocks(const Part& part) {
    if (!geometry_.triangles.empty()) {
      // Blocks are in another order than triangles, so that what they need is found slowly one by one: it is asked for
      // at once. (A function that does no more than this counts as without effect.)
      const std::span<const BoundedTriangle> below(&binary_.triangles[part.root.first], part.root.count);
      for (const BoundedTriangle& each : below) __builtin_prefetch(&geometry_.triangles[each.triangle]);
      for (const BoundedTriangle& each : below) {
        const Triangle& triangle = geometry_.triangles[each.triangle];
        __builtin_prefetch(&geometry_.vertices[triangle.v0]);
        __builtin_prefetch(&geometry_.vertices[triangle.v1]);
        __builtin_prefetch(&geometry_.vertices[triangle.v2]);
      }
    }
    uint32_t block = part.first_block;
    for (const Subtree& leaf : part.leaves) write_block(block++, leaf);
  }

  void write_block(uint32_t block, const Subtree& leaf) {
    const auto size = static_cast<uint32_t>(out_.leaf_size_);
    uint32_t* const words = &out_.blocks_[out_.block_word(block)];
    uint32_t* const ids = words + LUCARIUM_BVH_BLOCK_TRIANGLES(size);
    for (uint32_t slot = 0; slot < size; ++slot)
      ids[slot] = slot < leaf.count ? binary_.triangles[leaf.first + slot].triangle : LUCARIUM_NO_HIT;
    if (geometry_.triangles.empty() || size % 4) {
      std::fill_n(words, LUCARIUM_BVH_BLOCK_TRIANGLES(size), 0u);
      return;
    }
    for (uint32_t four = 0; four < size; four += 4) {
      Lanes corners[4][3] = {};  // those of empty slots are zero
      for (uint32_t slot = four; slot < std::min(four + 4, leaf.count); ++slot) {
        const Triangle& triangle = geometry_.triangles[ids[slot]];
        corners[slot - four][0] = load_position(geometry_.vertices[triangle.v0]);
        corners[slot - four][1] = load_position(geometry_.vertices[triangle.v1]);
        corners[slot - four][2] = load_position(geometry_.vertices[triangle.v2]);
      }
      for (uint32_t corner = 0; corner < 3; ++corner) {
        const auto [x, y, z] =
            transposed(corners[0][corner], corners[1][corner], corners[2][corner], corners[3][corner]);
        std::memcpy(words + (3 * corner + 0) * size + four, &x, sizeof(x));
        std::memcpy(words + (3 * corner + 1) * size + four, &y, sizeof(y));
        std::memcpy(words + (3 * corner + 2) * size + four, &z, sizeof(z));
      }
    }
  }

  void sum_up() {
    double area = top_.area;
    for (const Part& part : parts_) area += part.area;
    out_.bounds_ = child_box(binary_.root());
    const double root_area = static_cast<double>(out_.bounds_.half_area());
    out_.sah_cost_ = root_area > 0 ? 1 + area / root_area : 1;
  }

  const BinaryBvh& binary_;
  WideBvh& out_;
  const Geometry& geometry_;
  unsigned threads_;
  CollapsePlan plan_;
  Part top_;
  std::vector<Part> parts_;
};

WideBvh::WideBvh(const BinaryBvh& binary, int width, int leaf_size, const Geometry& geometry, unsigned threads)
    : width_(width), leaf_size_(leaf_size) {
  Emission(binary, *this, geometry, threads).run();
}

}  // namespace lucarium
