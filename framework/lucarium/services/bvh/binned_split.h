// SPDX-License-Identifier: Apache-2.0
// Where the surface area heuristic divides a range of triangles.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "lucarium/services/bvh/box_lanes.h"
#include "lucarium/services/bvh/build.h"

namespace lucarium {

/// Maps twice the centre to bins, one lane an axis. What does not depend on the order of triangles depends on no
/// thread, so that boxes are exact: minima of the same numbers.
struct BinMap {
  Lanes origin, scale;
  int bins;

  /// `centres` is the box around twice the centres.
  BinMap(const BoxLanes& centres, uint32_t count)
      : origin(centres.lower),
        // Few triangles are not worth many bins, and many triangles are worth more.
        bins(static_cast<int>(std::min({4 + count / 2, 16 + count / 128, uint32_t{max_bins}}))) {
    origin[3] = 0;
    const Lanes extent = centres.size();
    // The scale stays finite: extents so small that bins / extent overflows are treated as none.
    for (int axis = 0; axis < 3; ++axis)
      scale[axis] = extent[axis] > 1e-30f ? static_cast<float>(bins) * 0.99999f / extent[axis] : 0.f;
    scale[3] = 0;
  }
  /// At least 0 and less than `bins`.
  Lanes operator()(Lanes centre2) const { return (centre2 - origin) * scale; }

  static constexpr int max_bins = 32;
};

struct Split {
  int axis = -1;  // -1: all centres coincide
  int bin = 0;    // triangles in bins below this one go left
  uint32_t left_count = 0;
  BoxLanes left, right;
};

struct Bins {
  BoxLanes box[3][BinMap::max_bins];
  IntLanes count[BinMap::max_bins];  // one lane an axis

  explicit Bins(int bins) {
    for (int bin = 0; bin < bins; ++bin) {
      for (auto& of_axis : box) of_axis[bin] = BoxLanes::empty();
      count[bin] = IntLanes{};
    }
  }
  /// Neighbours tend to go to the same bins, where one waits for the other: the halves take turns.
  void add(const BoundedTriangle* triangles, uint32_t number, const BinMap& map) {
    const uint32_t half = number / 2;
    for (const BoundedTriangle* triangle = triangles; triangle != triangles + half; ++triangle) {
      add(*triangle, map);
      add(triangle[half], map);
    }
    if (number % 2) add(triangles[number - 1], map);
  }
  void add(const BoundedTriangle& triangle, const BinMap& map) {
    const BoxLanes one(triangle);
    const IntLanes bin = __builtin_convertvector(map(one.centre2()), IntLanes);
    add(0, bin[0], one);
    add(1, bin[1], one);
    add(2, bin[2], one);
  }
  void add(int axis, int bin, const BoxLanes& one) {
    box[axis][bin].add(one);
    ++count[bin][axis];
  }
  void add(const Bins& other, int bins) {
    for (int bin = 0; bin < bins; ++bin) {
      for (int axis = 0; axis < 3; ++axis) box[axis][bin].add(other.box[axis][bin]);
      count[bin] += other.count[bin];
    }
  }
  uint32_t count_below(int axis, int bin) const {
    uint32_t sum = 0;
    for (int b = 0; b < bin; ++b) sum += static_cast<uint32_t>(count[b][axis]);
    return sum;
  }

  /// The cheapest split, axes side by side in lanes.
  Split best_split(int bins) const {
    // Where one side has no triangles the cost is no number: the area of an empty box, infinite, times zero.
    Lanes right_cost[BinMap::max_bins];
    std::array<BoxLanes, 3> side = {BoxLanes::empty(), BoxLanes::empty(), BoxLanes::empty()};
    IntLanes triangles = {};
    const auto grow = [&](int bin) {
      side[0].add(box[0][bin]);
      side[1].add(box[1][bin]);
      side[2].add(box[2][bin]);
      triangles += count[bin];
      return half_areas(side[0], side[1], side[2]) * __builtin_convertvector(triangles, Lanes);
    };
    for (int bin = bins - 1; bin > 0; --bin) right_cost[bin] = grow(bin);
    side = {BoxLanes::empty(), BoxLanes::empty(), BoxLanes::empty()};
    triangles = IntLanes{};
    Lanes best_cost = splat(INFINITY);
    IntLanes best_bin = {};
    for (int bin = 1; bin < bins; ++bin) {
      const Lanes cost = grow(bin - 1) + right_cost[bin];
      const IntLanes better = cost < best_cost;
      best_cost = better ? cost : best_cost;
      best_bin = better ? IntLanes{bin, bin, bin, bin} : best_bin;
    }
    Split best;
    float least = INFINITY;
    for (int axis = 0; axis < 3; ++axis)
      if (best_cost[axis] < least) least = best_cost[axis], best.axis = axis, best.bin = best_bin[axis];
    if (best.axis < 0) return best;
    best.left_count = count_below(best.axis, best.bin);
    best.left = best.right = BoxLanes::empty();
    for (int bin = 0; bin < bins; ++bin) (bin < best.bin ? best.left : best.right).add(box[best.axis][bin]);
    return best;
  }
};

/// Boxes around twice the centres of triangles that went left and right.
struct SideCentres {
  BoxLanes left = BoxLanes::empty(), right = BoxLanes::empty();

  void add(const SideCentres& other) {
    left.add(other.left);
    right.add(other.right);
  }
};

/// Copies triangles of the left side to `left` and others to `right`, in their order.
inline SideCentres partition(const BoundedTriangle* triangles, uint32_t number, const BinMap& map, const Split& split,
                             BoundedTriangle* left, BoundedTriangle* right) {
  SideCentres centres;
  const Lanes origin = splat(map.origin[split.axis]), scale = splat(map.scale[split.axis]);
  const Lanes border = splat(static_cast<float>(split.bin));
  for (const BoundedTriangle* triangle = triangles; triangle != triangles + number; ++triangle) {
    const BoxLanes one(*triangle);
    const Lanes centre = one.centre2(), negated = one.negated_upper - one.lower;
    const float along = triangle->lower[split.axis] - triangle->negated_upper[split.axis];
    const IntLanes goes_left = (splat(along) - origin) * scale < border, goes_right = ~goes_left;
    // Where all bits are set is no number, which a minimum leaves out.
    const auto unless = [](IntLanes mask, Lanes value) {
      return reinterpret_cast<Lanes>(reinterpret_cast<IntLanes>(value) | mask);
    };
    centres.left.add({unless(goes_right, centre), unless(goes_right, negated)});
    centres.right.add({unless(goes_left, centre), unless(goes_left, negated)});
    const bool to_left = goes_left[0] != 0;
    BoundedTriangle* place = to_left ? left : right;
    std::memcpy(place, triangle, sizeof(*place));
    left += to_left;
    right += !to_left;
  }
  return centres;
}

}  // namespace lucarium
