// SPDX-License-Identifier: Apache-2.0
// The lowest levels of a binary hierarchy.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "lucarium/services/bvh/box_lanes.h"
#include "lucarium/services/bvh/build.h"

namespace lucarium {

/// Triangles that fit into a leaf. Up to four are divided at least cost by the surface area heuristic among all ways to
/// divide them, more of them along the widest axis: most stay together, so that little depends on it. So many as may
/// stay undivided get one node.
class FewTriangles {
 public:
  /// How many, at most, where leaves have this size.
  static uint32_t max_count(uint32_t leaf_size) { return std::clamp(leaf_size, 4u, array_size); }

  FewTriangles(const BoundedTriangle* triangles, uint32_t count, uint32_t undivided)
      : count_(count), undivided_(undivided) {
    for (uint32_t i = 0; i < count; ++i) triangles_[i] = triangles[i], boxes_[i] = BoxLanes(triangles[i]);
  }

  /// Writes the nodes from number `node` on, and the triangles in their order. Returns the node behind the last one.
  uint32_t build(BinaryBvh::Node* nodes, uint32_t node, BoundedTriangle* place) {
    nodes_ = nodes;
    constexpr int all[array_size] = {0, 1, 2, 3, 4, 5, 6, 7};
    return build(all, count_, node, place);
  }

 private:
  static constexpr uint32_t array_size = 8;

  uint32_t build(const int* of, uint32_t count, uint32_t node, BoundedTriangle* place) {
    if (count > 4) return build_more(of, count, node, place);
    if (count == 4) return build_four(of, node, place);
    if (count == 3) return build_three(of, node, place);
    if (count == 2) return build_two(of[0], of[1], node, place);
    place[0] = triangles_[of[0]];
    return node;
  }

  void write(uint32_t node, const BoxLanes& box, uint32_t left_count, uint32_t right) {
    box.store(nodes_[node]);
    nodes_[node].left_count = left_count;
    nodes_[node].right = right;
  }

  uint32_t build_two(int a, int b, uint32_t node, BoundedTriangle* place) {
    write(node, joined(boxes_[a], boxes_[b]), 1, node + 1);
    place[0] = triangles_[a];
    place[1] = triangles_[b];
    return node + 1;
  }

  /// A pair and a single one.
  uint32_t build_three(const int* of, uint32_t node, BoundedTriangle* place) {
    const BoxLanes &a = boxes_[of[0]], &b = boxes_[of[1]], &c = boxes_[of[2]];
    const BoxLanes ab = joined(a, b);
    write(node, joined(ab, c), 2, node + 2);
    if (undivided_ >= 3) {
      for (int i = 0; i < 3; ++i) place[i] = triangles_[of[i]];
      return node + 1;
    }
    const Lanes cost = splat(2) * half_areas(ab, joined(a, c), joined(b, c)) + half_areas(c, b, a);
    constexpr int ways[][3] = {{0, 1, 2}, {0, 2, 1}, {1, 2, 0}};
    const int* const way = ways[cost[2] < cost[0] && cost[2] < cost[1] ? 2 : cost[1] < cost[0] ? 1 : 0];
    build_two(of[way[0]], of[way[1]], node + 1, place);
    place[2] = triangles_[of[way[2]]];
    return node + 2;
  }

  /// Three and a single one, or two pairs.
  uint32_t build_four(const int* of, uint32_t node, BoundedTriangle* place) {
    const BoxLanes &a = boxes_[of[0]], &b = boxes_[of[1]], &c = boxes_[of[2]], &d = boxes_[of[3]];
    const BoxLanes ab = joined(a, b), ac = joined(a, c), ad = joined(a, d);
    const BoxLanes bc = joined(b, c), bd = joined(b, d), cd = joined(c, d);
    const Lanes pairs = splat(2) * (half_areas(ab, ac, ad) + half_areas(cd, bd, bc));
    const Lanes singles = splat(3) * half_areas(joined(ab, c), joined(ab, d), joined(ac, d)) + half_areas(d, c, b);
    const Lanes last = half_areas(joined(bc, d), a, a);
    const float costs[] = {pairs[0], pairs[1], pairs[2], singles[0], singles[1], singles[2], 3 * last[0] + last[1]};
    int best = 0;
    for (int way = 1; way < 7; ++way) best = costs[way] < costs[best] ? way : best;
    constexpr int ways[7][4] = {{0, 1, 2, 3}, {0, 2, 1, 3}, {0, 3, 1, 2}, {0, 1, 2, 3},
                                {0, 1, 3, 2}, {0, 2, 3, 1}, {1, 2, 3, 0}};
    const int* const way = ways[best];
    const int ordered[4] = {of[way[0]], of[way[1]], of[way[2]], of[way[3]]};
    return divide(ordered, 4, best < 3 ? 2 : 3, joined(ab, cd), node, place);
  }

  /// Those in front of any place along the widest axis, and those behind it.
  uint32_t build_more(const int* of, uint32_t count, uint32_t node, BoundedTriangle* place) {
    int sorted[array_size];
    sort(of, count, sorted);
    BoxLanes behind[array_size];
    behind[count - 1] = boxes_[sorted[count - 1]];
    for (uint32_t i = count - 1; i-- > 1;) behind[i] = joined(boxes_[sorted[i]], behind[i + 1]);
    BoxLanes front = boxes_[sorted[0]];
    float least = INFINITY;
    uint32_t left = 1;
    for (uint32_t i = 1; i < count; ++i) {
      const Lanes areas = half_areas(front, behind[i], front);
      const float cost = static_cast<float>(i) * areas[0] + static_cast<float>(count - i) * areas[1];
      left = cost < least ? i : left;
      least = cost < least ? cost : least;
      front.add(boxes_[sorted[i]]);
    }
    return divide(sorted, count, left, front, node, place);
  }

  /// By their centres along the widest axis; of equal ones the first remains in front.
  void sort(const int* of, uint32_t count, int* sorted) const {
    Lanes centre[array_size];
    BoxLanes centres = BoxLanes::empty();
    for (uint32_t i = 0; i < count; ++i) {
      centre[i] = boxes_[of[i]].centre2();
      centres.add({centre[i], -centre[i]});
    }
    const Lanes extent = centres.size();
    const int axis = extent[0] >= extent[1] && extent[0] >= extent[2] ? 0 : extent[1] >= extent[2] ? 1 : 2;
    alignas(16) float along[array_size];
    for (uint32_t i = 0; i < array_size; ++i) along[i] = i < count ? centre[i][axis] : INFINITY;
    Lanes low, high;
    std::memcpy(&low, along, sizeof(low));
    std::memcpy(&high, along + 4, sizeof(high));
    constexpr IntLanes low_number = {0, 1, 2, 3}, high_number = {4, 5, 6, 7};
    IntLanes low_rank = {}, high_rank = {};
    for (uint32_t i = 0; i < count; ++i) {
      const Lanes other = splat(along[i]);
      const IntLanes number = splat_int(static_cast<int>(i));
      low_rank -= (other < low) | ((other == low) & (low_number > number));
      high_rank -= (other < high) | ((other == high) & (high_number > number));
    }
    for (uint32_t i = 0; i < count; ++i) sorted[i < 4 ? low_rank[i] : high_rank[i - 4]] = of[i];
  }

  /// Builds the first `left` of these and the others.
  uint32_t divide(const int* of, uint32_t count, uint32_t left, const BoxLanes& box, uint32_t node,
                  BoundedTriangle* place) {
    const uint32_t right = build(of, left, node + 1, place);
    write(node, box, left, right);
    return build(of + left, count - left, right, place + left);
  }

  uint32_t count_, undivided_;
  BoundedTriangle triangles_[array_size];
  BoxLanes boxes_[array_size];
  BinaryBvh::Node* nodes_ = nullptr;
};

}  // namespace lucarium
