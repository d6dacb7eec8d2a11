// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/bvh/two_level_bvh.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <tuple>

#include "lucarium/base/error.h"

namespace lucarium {

void TwoLevelBvh::build(std::span<const Vertex> vertices, std::span<const Triangle> triangles,
                        std::vector<Part> parts) {
  ranges_ = std::move(parts);
  if (ranges_.empty()) ranges_.emplace_back();
  trees_.assign(ranges_.size(), {});
  keep_ = false;
  std::vector<size_t> all(trees_.size());
  std::iota(all.begin(), all.end(), size_t{0});
  for (const size_t part : all) rebuild(part, vertices, triangles);
  lay_out();
  write(all);
}

void TwoLevelBvh::join(std::span<const size_t> changed) {
  if (layout_fits()) {
    write(changed);
    return;
  }
  std::vector<size_t> all(trees_.size());
  std::iota(all.begin(), all.end(), size_t{0});
  lay_out();
  write(all);
}

void TwoLevelBvh::rebuild(size_t part, std::span<const Vertex> vertices, std::span<const Triangle> triangles) {
  Tree& tree = trees_[part];
  LargeArray<BoundedTriangle> bounded;
  size_t count = 0;
  for (const TriangleRange& range : ranges_[part]) count += range.count;
  bounded.reserve(count);
  tree.ignored.clear();
  for (const TriangleRange& range : ranges_[part])
    bound_triangles(vertices, triangles, range.first, range.count, threads_, bounded, tree.ignored);
  tree.triangles = static_cast<uint32_t>(bounded.size());
  tree.tree = WideBvh(build_binary_bvh(std::move(bounded), static_cast<uint32_t>(leaf_size_), threads_), width_,
                      leaf_size_, {vertices, triangles}, threads_);
  require_reach(tree.tree.node_count(), tree.tree.block_count());
  tree.built_cost = tree.tree.sah_cost();
  ++builds_;
}

bool TwoLevelBvh::refit(size_t part, std::span<const Vertex> vertices, std::span<const Triangle> triangles) {
  Tree& tree = trees_[part];
  Bounds unused;
  for (const uint32_t triangle : tree.ignored) {
    if (bound_triangle(vertices, triangles[triangle], unused)) return false;
  }
  tree.tree.fit(vertices, triangles);
  ++refits_;
  return tree.tree.sah_cost() <= rebuild_ratio * tree.built_cost;
}

bool TwoLevelBvh::layout_fits() const {
  return std::all_of(trees_.begin(), trees_.end(), [](const Tree& tree) {
    return tree.tree.node_count() <= tree.nodes && tree.tree.block_count() <= tree.blocks;
  });
}

/// Gives every part its place: top, then the parts' nodes; children follow their parents. The top over n parts has at
/// most n − 1 nodes, since each has two children or more.
void TwoLevelBvh::lay_out() {
  node_count_ = has_top() ? static_cast<uint32_t>(trees_.size()) - 1 : 0;
  block_count_ = 0;
  for (Tree& tree : trees_) {
    tree.first_node = node_count_;
    tree.first_block = block_count_;
    tree.nodes = tree.tree.node_count();
    tree.blocks = tree.tree.block_count();
    node_count_ += tree.nodes;
    block_count_ += tree.blocks;
  }
  require_reach(node_count_, block_count_);
  if (!has_top() && !keep_) return;  // takes the words of its only tree
  nodes_.assign(node_word_count(), 0);
  blocks_.assign(block_word_count(), 0);
}

void TwoLevelBvh::require_reach(size_t nodes, size_t blocks) const {
  const size_t words = std::max(node_word(nodes), block_word(blocks));
  if (words < LUCARIUM_BVH_LEAF) return;
  throw_error(ErrorClass::device,
              "hierarchy of {} triangles: it takes {} words and references reach {}; use a scene with fewer triangles",
              triangle_count(), words, LUCARIUM_BVH_LEAF);
}

void TwoLevelBvh::release() {
  if (can_refit()) return;
  nodes_ = {};
  blocks_ = {};
}

void TwoLevelBvh::restore(Words nodes, Words blocks) {
  keep_ = true;
  if (released()) nodes_ = std::move(nodes), blocks_ = std::move(blocks);
  trees_[0].tree.put_words(nodes_, blocks_);
}

size_t TwoLevelBvh::host_bytes() const {
  size_t words = nodes_.size() + blocks_.size() + top_.node_words().size() + top_.block_words().size();
  for (const Tree& tree : trees_) words += tree.tree.node_words().size() + tree.tree.block_words().size();
  return sizeof(uint32_t) * words;
}

/// Brings the words of these parts and of the top up to date.
void TwoLevelBvh::write(std::span<const size_t> parts) {
  changed_nodes_.clear();
  changed_blocks_.clear();
  if (!has_top() && !keep_)
    take_tree();
  else
    for (const size_t part : parts) copy_tree(trees_[part]);
  if (has_top()) {
    build_top();
    copy_top();
  }
  const Bounds& bounds = has_top() ? top_.bounds() : trees_[0].tree.bounds();
  nodes_[LUCARIUM_BVH_HEADER_EXTENT] = std::bit_cast<uint32_t>(bounds.extent());
  nodes_[LUCARIUM_BVH_HEADER_SIZE] = std::bit_cast<uint32_t>(bounds.longest_side());
  changed_nodes_.emplace_back(0, LUCARIUM_BVH_HEADER_WORDS);
}

void TwoLevelBvh::build_top() {
  LargeArray<BoundedTriangle> items;
  for (uint32_t part = 0; part < trees_.size(); ++part)
    if (trees_[part].triangles > 0) items.emplace_back(trees_[part].tree.bounds(), part);
  top_ = WideBvh(build_binary_bvh(std::move(items), 1, 1), width_, 1, {}, 1);
}

void TwoLevelBvh::copy_top() {
  const size_t words = LUCARIUM_BVH_NODE_WORDS(width_), count = top_.node_count();
  std::copy_n(top_.node_words().begin() + LUCARIUM_BVH_HEADER_WORDS, count * words,
              nodes_.begin() + LUCARIUM_BVH_HEADER_WORDS);
  for_each_reference(0, count, [&](uint32_t reference) {
    if (!(reference & LUCARIUM_BVH_LEAF)) return reference;
    const uint32_t block = reference & ~LUCARIUM_BVH_LEAF;
    const uint32_t part = top_.block_words()[block + LUCARIUM_BVH_BLOCK_TRIANGLES(1)];
    return static_cast<uint32_t>(node_word(trees_[part].first_node));
  });
  changed_nodes_.emplace_back(LUCARIUM_BVH_HEADER_WORDS, LUCARIUM_BVH_HEADER_WORDS + count * words);
}

void TwoLevelBvh::copy_tree(const Tree& tree) {
  const size_t words = LUCARIUM_BVH_NODE_WORDS(width_), count = tree.tree.node_count();
  const size_t first = LUCARIUM_BVH_HEADER_WORDS + tree.first_node * words;
  std::copy_n(tree.tree.node_words().begin() + LUCARIUM_BVH_HEADER_WORDS, count * words,
              nodes_.begin() + static_cast<ptrdiff_t>(first));
  const auto node_shift = static_cast<uint32_t>(tree.first_node * words);
  const auto block_shift = static_cast<uint32_t>(block_word(tree.first_block));
  for_each_reference(tree.first_node, tree.first_node + count, [&](uint32_t reference) {
    return reference + (reference & LUCARIUM_BVH_LEAF ? block_shift : node_shift);
  });
  changed_nodes_.emplace_back(first, first + count * words);
  const size_t first_block = size_t{tree.first_block} * LUCARIUM_BVH_BLOCK_WORDS(leaf_size_);
  std::copy(tree.tree.block_words().begin(), tree.tree.block_words().end(),
            blocks_.begin() + static_cast<ptrdiff_t>(first_block));
  changed_blocks_.emplace_back(first_block, first_block + tree.tree.block_words().size());
}

/// The words of the only tree, without a copy.
void TwoLevelBvh::take_tree() {
  std::tie(nodes_, blocks_) = trees_[0].tree.take_words();
  changed_nodes_.emplace_back(LUCARIUM_BVH_HEADER_WORDS, nodes_.size());
  changed_blocks_.emplace_back(0, blocks_.size());
}

uint32_t TwoLevelBvh::stack_size() const {
  uint32_t deepest = 0;
  for (const Tree& tree : trees_) deepest = std::max(deepest, tree.tree.stack_size());
  return deepest + (has_top() ? top_.stack_size() : 0);
}

uint32_t TwoLevelBvh::triangle_count() const {
  uint32_t count = 0;
  for (const Tree& tree : trees_) count += tree.triangles - tree.tree.dead_count();
  return count;
}

uint32_t TwoLevelBvh::ignored_count() const {
  size_t count = 0;
  for (const Tree& tree : trees_) count += tree.ignored.size() + tree.tree.dead_count();
  return static_cast<uint32_t>(count);
}

double TwoLevelBvh::sah_cost() const {
  if (!has_top()) return trees_.empty() ? 0 : trees_[0].tree.sah_cost();
  const double area = static_cast<double>(top_.bounds().half_area());
  if (area <= 0) return top_.sah_cost();
  // The top's cost counts the visit of each part's root once, and so does the part's own.
  double cost = top_.sah_cost();
  for (const Tree& tree : trees_) {
    if (tree.triangles > 0)
      cost += (tree.tree.sah_cost() - 1) * static_cast<double>(tree.tree.bounds().half_area()) / area;
  }
  return cost;
}

}  // namespace lucarium
