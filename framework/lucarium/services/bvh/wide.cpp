// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/bvh/wide.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "lucarium/shared/ray.h"

namespace lucarium {

namespace {

constexpr int max_width = 16;
constexpr uint32_t nodes_per_thread = 8192;

}  // namespace

/// Chooses which binary nodes survive as wide nodes, leaves and children, by dynamic programming over "the cheapest way
/// to represent a subtree by at most j roots" (Ylitie, Karras, Laine, "Efficient Incoherent Ray Traversal on GPUs
/// Through Compressed Wide BVHs", 2017, section 3.1, equations 2 to 4), with equal costs for a node and a leaf block.
class WideBvh::Collapse {
 public:
  Collapse(const BinaryBvh& binary, WideBvh& out, unsigned threads)
      : binary_(binary),
        out_(out),
        width_(out.width_),
        fork_join_(threads),
        choices_(binary.nodes.size()),
        visits_(binary.nodes.size()) {}

  void run() {
    if (!binary_.nodes.empty()) plan(0);
    out_.stack_size_ = emit_node(0).stack;
  }

 private:
  using Costs = std::array<float, max_width + 1>;  // [j]: with at most j roots, 1 ≤ j ≤ number of triangles below

  /// For j ≥ 2: how many of j roots go to the left subtree, 0: j − 1 roots are as good. [1]: 1 for a leaf block.
  /// [0]: how many of `width` roots go left when the node itself becomes a wide node.
  using Choices = std::array<uint8_t, max_width + 1>;

  Costs plan(uint32_t index) {
    const BinaryBvh::Node& node = binary_.nodes[index];
    const float area = node.box.half_area();
    Choices& choice = choices_[index];
    Costs cost;
    if (node.count == 1) {
      choice[1] = 1;
      visits_[index] = 1;
      cost[1] = area;
      return cost;
    }
    const uint32_t left = binary_.left(index), right = binary_.right(index);
    Costs left_cost, right_cost;
    fork_join_.run(
        node.count > nodes_per_thread, [&] { left_cost = plan(left); }, [&] { right_cost = plan(right); });
    const int left_max = static_cast<int>(std::min<uint32_t>(binary_.nodes[left].count, max_width));
    const int right_max = static_cast<int>(std::min<uint32_t>(binary_.nodes[right].count, max_width));
    const int max_count = std::min(width_, static_cast<int>(std::min<uint32_t>(node.count, max_width)));
    const auto distribute = [&](int roots, uint8_t& best_left) {
      float best = INFINITY;
      for (int k = std::max(1, roots - right_max); k <= std::min(roots - 1, left_max); ++k) {
        const float total = left_cost[k] + right_cost[roots - k];
        if (total < best) best = total, best_left = static_cast<uint8_t>(k);
      }
      return best;
    };
    const float inner = area + distribute(max_count, choice[0]);
    const float leaf = node.count <= static_cast<uint32_t>(out_.leaf_size_) ? area : INFINITY;
    choice[1] = leaf <= inner;
    cost[1] = std::min(leaf, inner);
    visits_[index] = area > 0 ? cost[1] / area : 1;
    for (int j = 2; j <= max_count; ++j) {
      cost[j] = distribute(j, choice[j]);
      if (cost[j - 1] <= cost[j]) cost[j] = cost[j - 1], choice[j] = 0;
    }
    return cost;
  }

  struct Emitted {
    uint32_t reference, stack;  // stack: most references waiting while this one's subtree is traversed
  };

  Emitted emit_node(uint32_t index) {
    const uint32_t self = out_.node_count_++;
    out_.nodes_.resize(out_.nodes_.size() + LUCARIUM_BVH_NODE_WORDS(width_));
    std::vector<uint32_t> roots;
    if (!binary_.nodes.empty()) {
      const int left = choices_[index][0];
      if (binary_.nodes[index].count == 1) {
        roots.push_back(index);
      } else {
        collect_roots(binary_.left(index), left, roots);
        collect_roots(binary_.right(index), width_ - left, roots);
      }
    }
    const uint32_t count = static_cast<uint32_t>(roots.size());
    out_.node(self)[LUCARIUM_BVH_NODE_ORDER(width_)] = arrange(roots);
    uint32_t deepest = 0;
    for (int slot = 0; slot < width_; ++slot) {
      uint32_t reference = no_child;
      if (const uint32_t root = roots[slot]; root != no_child) {
        const Emitted child = choices_[root][1] ? emit_block(root) : emit_node(root);
        reference = child.reference;
        deepest = std::max(deepest, child.stack);
      }
      out_.node(self)[LUCARIUM_BVH_NODE_REFERENCES(width_) + slot] = reference;
    }
    return {self, count + deepest};
  }

  void collect_roots(uint32_t index, int roots, std::vector<uint32_t>& out) {
    roots = static_cast<int>(std::min<uint32_t>(roots, binary_.nodes[index].count));
    while (roots > 1 && choices_[index][roots] == 0) --roots;
    if (roots == 1) {
      out.push_back(index);
      return;
    }
    const int left = choices_[index][roots];
    collect_roots(binary_.left(index), left, out);
    collect_roots(binary_.right(index), roots - left, out);
  }

  float centre2(uint32_t root, int axis) const {
    const Bounds& box = binary_.nodes[root].box;
    return box.min[axis] + box.max[axis];
  }

  /// Sorts [begin, end) along an axis, high to low, and returns how far its halves lie apart.
  float sort_along(std::vector<uint32_t>::iterator begin, std::vector<uint32_t>::iterator end, int axis) const {
    if (end - begin < 2) return 0;
    std::sort(begin, end, [&](uint32_t a, uint32_t b) {
      const float x = centre2(a, axis), y = centre2(b, axis);
      return x != y ? x > y : a < b;
    });
    const auto middle = begin + (end - begin) / 2;
    float high = 0, low = 0;
    for (auto root = begin; root != end; ++root) (root < middle ? high : low) += centre2(*root, axis);
    return high / static_cast<float>(middle - begin) - low / static_cast<float>(end - middle);
  }

  /// Arranges the roots in slots (empty ones: no_child) such that every bit of a slot's number, from the highest one
  /// down, separates its group along one axis, the one of largest separation. Any-hit rays take the highest slot first,
  /// wherever they go: 1 marks the half that is cheaper to traverse, which is the better one to try while nothing is
  /// known about where hits are. Returns the order word, with which others find their nearest child.
  uint32_t arrange(std::vector<uint32_t>& roots) const {
    struct Group {
      uint32_t slot;
      std::vector<uint32_t> roots;
    };
    std::vector<Group> groups = {{0, roots}};
    uint32_t order = 0;
    for (uint32_t bit = static_cast<uint32_t>(width_) / 2; bit > 0; bit /= 2) {
      int axis = 0;
      float best = -1;
      for (int candidate = 0; candidate < 3; ++candidate) {
        float separation = 0;
        for (Group& group : groups) separation += sort_along(group.roots.begin(), group.roots.end(), candidate);
        if (separation > best) best = separation, axis = candidate;
      }
      std::vector<Group> high, low;
      float high_ease = 0, low_ease = 0;
      for (Group& group : groups) {
        sort_along(group.roots.begin(), group.roots.end(), axis);
        const auto middle = group.roots.begin() + static_cast<ptrdiff_t>(group.roots.size() / 2);
        high.push_back({group.slot, {group.roots.begin(), middle}});
        low.push_back({group.slot, {middle, group.roots.end()}});
        for (const uint32_t root : high.back().roots) high_ease += 1 / visits_[root];
        for (const uint32_t root : low.back().roots) low_ease += 1 / visits_[root];
      }
      const bool high_first = high_ease > low_ease;
      for (Group& group : high_first ? high : low) group.slot |= bit;
      // A ray in negative direction sees the high half first.
      for (uint32_t octant = 0; octant < 8; ++octant)
        if ((octant >> axis & 1) != (high_first ? 1u : 0u)) order |= bit << (4 * octant);
      groups = std::move(high);
      groups.insert(groups.end(), low.begin(), low.end());
    }
    roots.assign(static_cast<size_t>(width_), no_child);
    for (const Group& group : groups)
      if (!group.roots.empty()) roots[group.slot] = group.roots.front();
    return order;
  }

  Emitted emit_block(uint32_t index) {
    const BinaryBvh::Node& node = binary_.nodes[index];
    const uint32_t block = out_.block_count_++;
    out_.blocks_.resize(out_.block_word(block + size_t{1}));
    uint32_t* ids = &out_.blocks_[out_.block_word(block) + LUCARIUM_BVH_BLOCK_TRIANGLES(out_.leaf_size_)];
    for (int slot = 0; slot < out_.leaf_size_; ++slot)
      ids[slot] = static_cast<uint32_t>(slot) < node.count ? binary_.order[node.first + slot] : LUCARIUM_NO_HIT;
    return {LUCARIUM_BVH_LEAF | block, 0};
  }

  const BinaryBvh& binary_;
  WideBvh& out_;
  int width_;
  ForkJoin fork_join_;
  std::vector<Choices> choices_;
  std::vector<float>
      visits_;  // expected number of nodes and leaf blocks of a subtree that a ray visits which enters it
};

WideBvh::WideBvh(const BinaryBvh& binary, int width, int leaf_size, unsigned threads)
    : width_(width), leaf_size_(leaf_size), nodes_(LUCARIUM_BVH_HEADER_WORDS) {
  Collapse collapse(binary, *this, threads);
  collapse.run();
}

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

template <class LeafBox>
void WideBvh::fit_boxes(LeafBox&& leaf_box) {
  std::vector<Bounds> boxes(node_count_);
  double cost = 0;
  // Children follow their parents, so that backwards every child is ready before its parent needs it.
  for (uint32_t index = node_count_; index-- > 0;) {
    for (int slot = 0; slot < width_; ++slot) {
      const uint32_t reference = node(index)[LUCARIUM_BVH_NODE_REFERENCES(width_) + slot];
      Bounds box;
      if (reference != no_child)
        box = reference & LUCARIUM_BVH_LEAF ? leaf_box(reference & ~LUCARIUM_BVH_LEAF) : boxes[reference];
      set_child_box(index, slot, box);
      boxes[index].add(box);
      cost += static_cast<double>(box.half_area());
    }
  }
  bounds_ = boxes[0];
  const double root_area = static_cast<double>(bounds_.half_area());
  sah_cost_ = root_area > 0 ? 1 + cost / root_area : 1;
}

void WideBvh::fit(std::span<const Vertex> vertices, std::span<const Triangle> triangles) {
  dead_count_ = 0;
  fit_boxes([&](uint32_t block) { return fit_block(block, vertices, triangles); });
}

void WideBvh::fit_items(std::span<const Bounds> boxes) {
  fit_boxes(
      [&](uint32_t block) { return boxes[blocks_[block_word(block) + LUCARIUM_BVH_BLOCK_TRIANGLES(leaf_size_)]]; });
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
