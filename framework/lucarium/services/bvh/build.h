// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "lucarium/base/parallel.h"
#include "lucarium/scene/bounds.h"
#include "lucarium/shared/scene_types.h"

namespace lucarium {

/// Largest coordinate that traversal handles without overflow [m]; triangles beyond it are never hit.
inline constexpr float bvh_coordinate_limit = 1e12f;

/// Box of a triangle. Returns false for one that nothing can hit: an index or a coordinate out of range, a coordinate
/// that is not finite, or no area.
bool bound_triangle(std::span<const Vertex> vertices, const Triangle& triangle, Bounds& box);

struct BoundedTriangle {
  Bounds box;
  uint32_t triangle = 0;
};

/// Binary hierarchy down to single triangles. A subtree of n triangles takes 2n − 1 consecutive nodes: the left child
/// of node i is i + 1, the right one i + 2 · nodes[i + 1].count, so that subtrees can be built in parallel and the
/// result does not depend on how.
struct BinaryBvh {
  struct Node {
    Bounds box;
    uint32_t first = 0, count = 0;  ///< triangles below, a range of `order`
  };
  std::vector<Node> nodes;
  std::vector<uint32_t> order;  ///< triangle indices

  uint32_t left(uint32_t node) const { return node + 1; }
  uint32_t right(uint32_t node) const { return node + 2 * nodes[node + 1].count; }
};

/// Top-down build by the surface area heuristic with 16 bins on each of 3 axes (Wald, "On fast Construction of
/// SAH-based Bounding Volume Hierarchies", 2007). Deterministic for any number of threads; depth at most 48 + log2(n).
BinaryBvh build_binary_bvh(std::vector<BoundedTriangle> triangles, unsigned threads);

}  // namespace lucarium
