// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <vector>

#include "lucarium/services/bvh/wide.h"

namespace lucarium {

/// Consecutive triangles.
struct TriangleRange {
  uint32_t first = 0, count = 0;
  bool operator==(const TriangleRange&) const = default;
};

/// Hierarchies of parts of a scene that move independently, joined by a small one over their boxes into a single wide
/// hierarchy in one memory layout. A part that moves is refitted, or rebuilt when its quality drops; all others
/// stay: a part's motion costs what that part and the top cost. A single part has no top and is
/// a plain hierarchy; its words are held once until it is refitted, and can be given up meanwhile. Otherwise they are
/// held twice, as parts and joined.
class TwoLevelBvh {
 public:
  /// A part is rebuilt when its SAH cost has grown by this factor since it was built.
  static constexpr double rebuild_ratio = 1.5;

  using Words = WideBvh::Words;
  using Part = std::vector<TriangleRange>;

  TwoLevelBvh(int width, int leaf_size, unsigned threads) : width_(width), leaf_size_(leaf_size), threads_(threads) {}

  /// Builds everything: one hierarchy for each part. Empty parts are allowed, also none.
  void build(std::span<const Vertex> vertices, std::span<const Triangle> triangles, std::vector<Part> parts);
  /// The vertices of a part have moved: fits its boxes to them. Returns false when it must be rebuilt, because it has
  /// become worse than rebuild_ratio or a triangle that could not be hit now can. can_refit() must be true.
  bool refit(size_t part, std::span<const Vertex> vertices, std::span<const Triangle> triangles);
  void rebuild(size_t part, std::span<const Vertex> vertices, std::span<const Triangle> triangles);
  /// After parts were refitted or rebuilt: brings everything together again.
  void join(std::span<const size_t> changed);

  /// Whether the parts' own words are there; if not, restore() brings them back.
  bool can_refit() const { return trees_.empty() || trees_[0].tree.has_words() || has_top(); }
  /// Gives up the words of a hierarchy that cannot be refitted, to be called when they have been copied elsewhere.
  void release();
  /// From the words that release() gave up (node_word_count() and block_word_count() of them), or without them from
  /// those here.
  void restore(Words nodes, Words blocks);
  bool released() const { return nodes_.empty(); }
  size_t node_word_count() const { return node_word(node_count_); }
  size_t block_word_count() const { return block_word(block_count_); }
  size_t host_bytes() const;  ///< of all words here

  const std::vector<Part>& parts() const { return ranges_; }
  const Words& node_words() const { return nodes_; }
  const Words& block_words() const { return blocks_; }
  /// Words that the last build() or join() changed, as [first, end).
  std::span<const std::pair<size_t, size_t>> changed_nodes() const { return changed_nodes_; }
  std::span<const std::pair<size_t, size_t>> changed_blocks() const { return changed_blocks_; }

  uint32_t node_count() const { return node_count_; }
  uint32_t block_count() const { return block_count_; }
  uint32_t stack_size() const;
  uint32_t triangle_count() const;
  uint32_t ignored_count() const;
  /// Expected node and leaf block tests of a random line that crosses the box of everything.
  double sah_cost() const;
  uint64_t builds() const { return builds_; }  ///< of parts, since the beginning
  uint64_t refits() const { return refits_; }

 private:
  struct Tree {
    WideBvh tree;
    double built_cost = 0;
    uint32_t triangles = 0;
    std::vector<uint32_t> ignored;  ///< triangles that nothing could hit when it was built
    uint32_t first_node = 0, first_block = 0;
    uint32_t nodes = 0, blocks = 0;  ///< room in the layout
  };

  bool layout_fits() const;
  void lay_out();
  void write(std::span<const size_t> parts);
  void build_top();
  void copy_top();
  void copy_tree(const Tree& tree);
  void take_tree();
  void require_reach(size_t nodes, size_t blocks) const;
  bool has_top() const { return trees_.size() > 1; }
  size_t node_word(size_t index) const {
    return LUCARIUM_BVH_HEADER_WORDS + index * LUCARIUM_BVH_NODE_WORDS(static_cast<size_t>(width_));
  }
  size_t block_word(size_t index) const { return index * LUCARIUM_BVH_BLOCK_WORDS(static_cast<size_t>(leaf_size_)); }
  uint32_t* node(size_t index) { return &nodes_[node_word(index)]; }
  /// Calls change(reference) for those of nodes [first, end).
  template <class Change>
  void for_each_reference(size_t first, size_t end, Change&& change) {
    for (size_t index = first; index < end; ++index) {
      for (int slot = 0; slot < width_; ++slot) {
        uint32_t& reference = node(index)[LUCARIUM_BVH_NODE_REFERENCES(width_) + slot];
        if (reference != WideBvh::no_child) reference = change(reference);
      }
    }
  }
  int width_, leaf_size_;
  unsigned threads_;
  std::vector<Part> ranges_;
  std::vector<Tree> trees_;
  WideBvh top_;
  bool keep_ = false;  // the words of a single part stay after they were joined
  Words nodes_, blocks_;
  std::vector<std::pair<size_t, size_t>> changed_nodes_, changed_blocks_;
  uint32_t node_count_ = 0, block_count_ = 0;
  uint64_t builds_ = 0, refits_ = 0;
};

}  // namespace lucarium
