// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "lucarium/scene/bounds.h"
#include "lucarium/services/bvh/box_lanes.h"
#include "lucarium/services/large_array.h"
#include "lucarium/shared/scene_types.h"

namespace lucarium {

/// Largest coordinate that traversal handles without overflow [m]; triangles beyond it are never hit.
inline constexpr float bvh_coordinate_limit = 1e12f;

/// Box of a triangle. Returns false for one that nothing can hit: an index or a coordinate out of range, a coordinate
/// that is not finite, or no area.
bool bound_triangle(std::span<const Vertex> vertices, const Triangle& triangle, Bounds& box);

/// A box as two vectors of four words (BoxLanes): upper bounds are negated, so that a minimum grows the box at all
/// sides. Both fourth words hold the triangle.
struct alignas(16) BoundedTriangle {
  float lower[3];
  uint32_t triangle;
  float negated_upper[3];
  uint32_t triangle_again;

  BoundedTriangle() = default;  // undefined
  BoundedTriangle(const Bounds& box, uint32_t index)
      : lower{box.min.x + 0.f, box.min.y + 0.f, box.min.z + 0.f},  // no negative zeros: a minimum keeps either zero
        triangle(index),
        negated_upper{-box.max.x, -box.max.y, -box.max.z},
        triangle_again(index) {}
};

/// Those of triangles [first, first + count) that something can hit; appends the others to `ignored`.
void bound_triangles(std::span<const Vertex> vertices, std::span<const Triangle> triangles, uint32_t first,
                     uint32_t count, unsigned threads, LargeArray<BoundedTriangle>& bounded,
                     std::vector<uint32_t>& ignored);

/// Binary hierarchy down to a few triangles. Single triangles have no nodes. The left child of node i is i + 1, and a
/// subtree of n triangles has n − 1 consecutive nodes to itself, of which it uses some, so that subtrees can be built
/// in parallel. Where nodes lie may depend on how, the hierarchy does not.
struct BinaryBvh {
  struct alignas(16) Node {
    float lower[3];
    uint32_t left_count;  ///< triangles below the left child
    float negated_upper[3];
    uint32_t right;  ///< the right child
  };
  LargeArray<Node> nodes;
  LargeArray<BoundedTriangle> triangles;  ///< those below a node stand together, the left child's first
  uint32_t undivided = 1;                 ///< subtrees of so many triangles have no children

  /// `node` is that of the subtree's root, and means nothing where there is but one triangle.
  struct Subtree {
    uint32_t node, first, count;
  };
  Subtree root() const { return {0, 0, static_cast<uint32_t>(triangles.size())}; }
  Subtree left(const Subtree& of) const { return {of.node + 1, of.first, nodes[of.node].left_count}; }
  Subtree right(const Subtree& of) const {
    const uint32_t left_count = nodes[of.node].left_count;
    return {nodes[of.node].right, of.first + left_count, of.count - left_count};
  }
  BoxLanes box(const Subtree& of) const {
    return of.count == 1 ? BoxLanes(triangles[of.first]) : BoxLanes(nodes[of.node]);
  }
};

/// Top-down build by the surface area heuristic with up to 16 bins on each of 3 axes (Wald, "On fast Construction of
/// SAH-based Bounding Volume Hierarchies", 2007), simpler where triangles fit into a leaf. Three stay undivided where
/// leaves have eight: less is hardly a leaf. Deterministic for any number of threads; depth at most 48 + log2(n).
BinaryBvh build_binary_bvh(LargeArray<BoundedTriangle> triangles, uint32_t leaf_size, unsigned threads);

}  // namespace lucarium
