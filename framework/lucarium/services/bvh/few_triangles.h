// SPDX-License-Identifier: Apache-2.0
// The lowest levels of a binary hierarchy.
#pragma once
#include <cstdint>

#include "lucarium/services/bvh/box_lanes.h"
#include "lucarium/services/bvh/build.h"

namespace lucarium {

/// One to four triangles, divided at least cost by the surface area heuristic among all ways to divide them. So many as
/// may stay undivided, fewer than four, get one node.
class FewTriangles {
 public:
  static constexpr uint32_t most = 4;

  FewTriangles(const BoundedTriangle* triangles, uint32_t count, uint32_t undivided)
      : count_(count), undivided_(undivided) {
    for (uint32_t i = 0; i < count; ++i) triangles_[i] = triangles[i], boxes_[i] = BoxLanes(triangles[i]);
  }

  /// Writes the nodes from number `node` on, and the triangles in their order. Returns the node behind the last one.
  uint32_t build(BinaryBvh::Node* nodes, uint32_t node, BoundedTriangle* place) {
    nodes_ = nodes;
    if (count_ == 4) return build_four(node, place);
    if (count_ == 3) return build_three({0, 1, 2}, node, place);
    if (count_ == 2) return build_two(0, 1, node, place);
    place[0] = triangles_[0];
    return node;
  }

 private:
  struct Three {
    int of[3];
  };

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
  uint32_t build_three(const Three& three, uint32_t node, BoundedTriangle* place) {
    const BoxLanes &a = boxes_[three.of[0]], &b = boxes_[three.of[1]], &c = boxes_[three.of[2]];
    const BoxLanes ab = joined(a, b);
    write(node, joined(ab, c), 2, node + 2);
    if (undivided_ >= 3) {
      for (int i = 0; i < 3; ++i) place[i] = triangles_[three.of[i]];
      return node + 1;
    }
    const Lanes cost = splat(2) * half_areas(ab, joined(a, c), joined(b, c)) + half_areas(c, b, a);
    constexpr Three ways[] = {{0, 1, 2}, {0, 2, 1}, {1, 2, 0}};
    const Three& way = ways[cost[2] < cost[0] && cost[2] < cost[1] ? 2 : cost[1] < cost[0] ? 1 : 0];
    build_two(three.of[way.of[0]], three.of[way.of[1]], node + 1, place);
    place[2] = triangles_[three.of[way.of[2]]];
    return node + 2;
  }

  /// Three and a single one, or two pairs.
  uint32_t build_four(uint32_t node, BoundedTriangle* place) {
    const BoxLanes &a = boxes_[0], &b = boxes_[1], &c = boxes_[2], &d = boxes_[3];
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
    const bool two_pairs = best < 3;
    uint32_t next = node + 1;
    if (two_pairs) {
      next = build_two(way[0], way[1], next, place);
      write(node, joined(ab, cd), 2, next);
      return build_two(way[2], way[3], next, place + 2);
    }
    next = build_three({way[0], way[1], way[2]}, next, place);
    write(node, joined(ab, cd), 3, next);
    place[3] = triangles_[way[3]];
    return next;
  }

  uint32_t count_, undivided_;
  BoundedTriangle triangles_[most];
  BoxLanes boxes_[most];
  BinaryBvh::Node* nodes_ = nullptr;
};

}  // namespace lucarium
