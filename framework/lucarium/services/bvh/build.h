// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "lucarium/base/parallel.h"
#include "lucarium/shared/scene_types.h"

namespace lucarium {

/// Axis-aligned box [m]; empty when lower > upper.
struct Box {
  std::array<float, 3> lower{1e30f, 1e30f, 1e30f}, upper{-1e30f, -1e30f, -1e30f};
  void add(const Box& other) {
    for (int axis = 0; axis < 3; ++axis) {
      lower[axis] = other.lower[axis] < lower[axis] ? other.lower[axis] : lower[axis];
      upper[axis] = other.upper[axis] > upper[axis] ? other.upper[axis] : upper[axis];
    }
  }
  float half_area() const {
    const float x = upper[0] - lower[0], y = upper[1] - lower[1], z = upper[2] - lower[2];
    return x < 0 ? 0.f : x * y + y * z + z * x;
  }
  /// Longest side; 0 when empty.
  float size() const {
    float longest = 0;
    for (int axis = 0; axis < 3; ++axis) longest = std::max(longest, upper[axis] - lower[axis]);
    return longest;
  }
  /// Largest absolute coordinate; 0 when empty.
  float extent() const {
    float largest = 0;
    for (int axis = 0; axis < 3 && lower[axis] <= upper[axis]; ++axis)
      largest = std::max({largest, std::fabs(lower[axis]), std::fabs(upper[axis])});
    return largest;
  }
};

/// Largest coordinate that traversal handles without overflow [m]; triangles beyond it are never hit.
inline constexpr float bvh_coordinate_limit = 1e12f;

/// Box of a triangle. Returns false for one that nothing can hit: an index or a coordinate out of range, a coordinate
/// that is not finite, or no area.
bool bound_triangle(std::span<const Vertex> vertices, const Triangle& triangle, Box& box);

struct BoundedTriangle {
  Box box;
  uint32_t triangle = 0;
};

/// Binary hierarchy down to single triangles. A subtree of n triangles takes 2n − 1 consecutive nodes: the left child
/// of node i is i + 1, the right one i + 2 · nodes[i + 1].count, so that subtrees can be built in parallel and the
/// result does not depend on how.
struct BinaryBvh {
  struct Node {
    Box box;
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
