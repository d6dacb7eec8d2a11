// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/bvh/build.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "lucarium/scene/device/degenerate_triangle.h"

namespace lucarium {

namespace {

constexpr int max_bins = 16;
constexpr int max_sah_depth = 48;                // deeper nodes are halved by count, which bounds recursion and stacks
constexpr uint32_t triangles_per_thread = 4096;  // triangles below which a thread is not worth its start

/// Twice the centre: sorting by it needs no division.
float centre2(const BoundedTriangle& triangle, int axis) { return triangle.box.min[axis] + triangle.box.max[axis]; }

/// Maps twice the centre to a bin; the same expression bins and partitions.
struct BinMap {
  float origin = 0, scale = 0;
  int last = 0;
  int operator()(float value) const { return std::min(static_cast<int>((value - origin) * scale), last); }
};

struct Split {
  int axis = -1;  // -1: all centres coincide
  int bin = 0;    // triangles in bins below this one go left
  float cost = INFINITY;
};

/// The first three lanes of one vector each, so that growing a box takes two instructions.
using Lanes = float __attribute__((vector_size(16)));

struct LaneBox {
  Lanes lower, upper;

  LaneBox() = default;  // undefined; see empty()
  /// Reads the word behind either corner, too: the box's next member, and the triangle's index.
  explicit LaneBox(const BoundedTriangle& triangle) {
    const auto* words = reinterpret_cast<const char*>(&triangle);
    static_assert(offsetof(BoundedTriangle, box) == 0 && offsetof(BoundedTriangle, triangle) == 6 * sizeof(float));
    std::memcpy(&lower, words, sizeof(lower));
    std::memcpy(&upper, words + 3 * sizeof(float), sizeof(upper));
  }
  static LaneBox empty() {
    LaneBox box;
    box.lower = Lanes{1e30f, 1e30f, 1e30f, 0};
    box.upper = -box.lower;
    return box;
  }
  void add(const LaneBox& other) {
    lower = other.lower < lower ? other.lower : lower;
    upper = other.upper > upper ? other.upper : upper;
  }
  Bounds box() const { return {{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}}; }
  float half_area() const { return box().half_area(); }
};

struct Bin {
  LaneBox box;
  uint32_t count;
};

class Builder {
 public:
  Builder(std::vector<BoundedTriangle>& triangles, BinaryBvh& out, unsigned threads)
      : triangles_(triangles), out_(out), fork_join_(threads) {}

  void build(uint32_t node, uint32_t first, uint32_t count, int depth) {
    BinaryBvh::Node& result = out_.nodes[node];
    result.first = first;
    result.count = count;
    LaneBox box = LaneBox::empty(), centre_box = LaneBox::empty();
    for (uint32_t i = first; i < first + count; ++i) {
      const LaneBox triangle(triangles_[i]);
      box.add(triangle);
      LaneBox centre;
      centre.lower = centre.upper = triangle.lower + triangle.upper;
      centre_box.add(centre);
    }
    result.box = box.box();
    const Bounds centres = centre_box.box();
    if (count == 1) return;
    const uint32_t left = count == 2              ? 1
                          : depth < max_sah_depth ? split(first, count, centres)
                                                  : halve(first, count, centres);
    fork_join_.run(
        count > triangles_per_thread, [&] { build(node + 1, first, left, depth + 1); },
        [&] { build(node + 2 * left, first + left, count - left, depth + 1); });
  }

 private:
  /// Partitions the range by the cheapest binned split; returns the size of the left part.
  uint32_t split(uint32_t first, uint32_t count, const Bounds& centres) {
    std::array<BinMap, 3> maps;
    const int bins = std::clamp(static_cast<int>(std::min<uint32_t>(count, max_bins)), 4, max_bins);
    for (int axis = 0; axis < 3; ++axis) {
      const float extent = centres.max[axis] - centres.min[axis];
      // The scale stays finite: extents so small that bins / extent overflows are treated as none.
      const bool usable = extent > 1e-30f;
      maps[axis] = {centres.min[axis], usable ? static_cast<float>(bins) * 0.99999f / extent : 0.f, bins - 1};
    }
    const Split best = find_split(first, count, maps, bins);
    if (best.axis < 0) return count / 2;
    const auto begin = triangles_.begin() + first;
    const auto middle = std::partition(begin, begin + count, [&](const BoundedTriangle& triangle) {
      return maps[best.axis](centre2(triangle, best.axis)) < best.bin;
    });
    return static_cast<uint32_t>(middle - begin);
  }

  Split find_split(uint32_t first, uint32_t count, const std::array<BinMap, 3>& maps, int bins) const {
    std::array<std::array<Bin, max_bins>, 3> bin;
    for (auto& of_axis : bin) std::fill_n(of_axis.begin(), bins, Bin{LaneBox::empty(), 0});
    for (uint32_t i = first; i < first + count; ++i) {
      const LaneBox box(triangles_[i]);
      const Lanes centre = box.lower + box.upper;
      for (int axis = 0; axis < 3; ++axis) {
        Bin& target = bin[axis][maps[axis](centre[axis])];
        target.box.add(box);
        ++target.count;
      }
    }
    Split best;
    for (int axis = 0; axis < 3; ++axis) {
      if (maps[axis].scale == 0) continue;
      float right_cost[max_bins];
      LaneBox box = LaneBox::empty();
      uint32_t below = 0;
      for (int b = bins - 1; b > 0; --b) {
        box.add(bin[axis][b].box);
        below += bin[axis][b].count;
        right_cost[b] = box.half_area() * static_cast<float>(below);
      }
      box = LaneBox::empty();
      below = 0;
      for (int b = 1; b < bins; ++b) {
        box.add(bin[axis][b - 1].box);
        below += bin[axis][b - 1].count;
        if (below == 0 || below == count) continue;
        const float cost = box.half_area() * static_cast<float>(below) + right_cost[b];
        if (cost < best.cost) best = {axis, b, cost};
      }
    }
    return best;
  }

  /// Halves the range at the median of the widest axis.
  uint32_t halve(uint32_t first, uint32_t count, const Bounds& centres) {
    int axis = 0;
    for (int other = 1; other < 3; ++other)
      if (centres.max[other] - centres.min[other] > centres.max[axis] - centres.min[axis]) axis = other;
    const auto begin = triangles_.begin() + first;
    std::nth_element(begin, begin + count / 2, begin + count, [&](const BoundedTriangle& a, const BoundedTriangle& b) {
      const float x = centre2(a, axis), y = centre2(b, axis);
      return x != y ? x < y : a.triangle < b.triangle;
    });
    return count / 2;
  }

  std::vector<BoundedTriangle>& triangles_;
  BinaryBvh& out_;
  ForkJoin fork_join_;
};

}  // namespace

bool bound_triangle(std::span<const Vertex> vertices, const Triangle& triangle, Bounds& box) {
  box = {};
  for (const uint32_t index : {triangle.v0, triangle.v1, triangle.v2}) {
    if (index >= vertices.size()) return false;
    const float4& p = vertices[index].position;
    for (const float coordinate : {p.x, p.y, p.z}) {
      if (!(std::fabs(coordinate) <= bvh_coordinate_limit)) return false;
    }
    box.add(p.xyz());
  }
  return !is_degenerate(vertices[triangle.v0], vertices[triangle.v1], vertices[triangle.v2]);
}

BinaryBvh build_binary_bvh(std::vector<BoundedTriangle> triangles, unsigned threads) {
  BinaryBvh result;
  if (triangles.empty()) return result;
  result.nodes.resize(2 * triangles.size() - 1);
  Builder(triangles, result, threads).build(0, 0, static_cast<uint32_t>(triangles.size()), 0);
  result.order.reserve(triangles.size());
  for (const BoundedTriangle& triangle : triangles) result.order.push_back(triangle.triangle);
  return result;
}

}  // namespace lucarium
