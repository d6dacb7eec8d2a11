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
        // Few triangles are not worth many bins.
        bins(static_cast<int>(std::min<uint32_t>(4 + count / 2, max_bins))) {
    origin[3] = 0;
    const Lanes extent = centres.size();
    // The scale stays finite: extents so small that bins / extent overflows are treated as none.
    for (int axis = 0; axis < 3; ++axis)
      scale[axis] = extent[axis] > 1e-30f ? static_cast<float>(bins) * 0.99999f / extent[axis] : 0.f;
    scale[3] = 0;
  }
  /// At least 0 and less than `bins`.
  Lanes operator()(Lanes centre2) const { return (centre2 - origin) * scale; }

  static constexpr int max_bins = 16;
};

struct Split {
  int axis = -1;  // -1: all centres coincide
  int bin = 0;    // triangles in bins below this one go left
  uint32_t left_count = 0;
  BoxLanes left, right;
};

struct Bins {
  struct Counts {
    IntLanes of_axes;  // one lane an axis
    IntLanes unused;   // makes the bins' places those of the boxes
  };
  BoxLanes box[3][BinMap::max_bins];
  Counts count[BinMap::max_bins];

  explicit Bins(int bins) {
    for (int bin = 0; bin < bins; ++bin) {
      for (auto& of_axis : box) of_axis[bin] = BoxLanes::empty();
      count[bin].of_axes = IntLanes{};
    }
  }
  /// Neighbours tend to go to the same bins, where one waits for the other: quarters take turns.
  void add(const BoundedTriangle* triangles, uint32_t number, const BinMap& map) {
    const uint32_t quarter = number / 4;
    for (uint32_t i = 0; i < quarter; ++i) {
      add(triangles[i], map);
      add(triangles[quarter + i], map);
      add(triangles[2 * quarter + i], map);
      add(triangles[3 * quarter + i], map);
    }
    for (uint32_t i = 4 * quarter; i < number; ++i) add(triangles[i], map);
  }
  void add(const BoundedTriangle& triangle, const BinMap& map) {
    static_assert(sizeof(BoxLanes) == 32 && sizeof(Counts) == 32);
    const BoxLanes one(triangle);
    const IntLanes place = __builtin_convertvector(map(one.centre2()), IntLanes) << 5;  // in bytes
    uint64_t first_two;
    std::memcpy(&first_two, &place, sizeof(first_two));
    add(0, static_cast<uint32_t>(first_two), one);
    add(1, first_two >> 32, one);
    add(2, static_cast<uint32_t>(place[2]), one);
  }
  void add(int axis, size_t place, const BoxLanes& one) {
    reinterpret_cast<BoxLanes*>(reinterpret_cast<char*>(box[axis]) + place)->add(one);
    ++reinterpret_cast<Counts*>(reinterpret_cast<char*>(count) + place)->of_axes[axis];
  }
  void add(const Bins& other, int bins) {
    for (int bin = 0; bin < bins; ++bin) {
      for (int axis = 0; axis < 3; ++axis) box[axis][bin].add(other.box[axis][bin]);
      count[bin].of_axes += other.count[bin].of_axes;
    }
  }
  uint32_t count_below(int axis, int bin) const {
    uint32_t sum = 0;
    for (int b = 0; b < bin; ++b) sum += static_cast<uint32_t>(count[b].of_axes[axis]);
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
      triangles += count[bin].of_axes;
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
  Lanes left_low = splat(1e30f), left_high = -left_low, right_low = left_low, right_high = left_high;
  const Lanes origin = splat(map.origin[split.axis]), scale = splat(map.scale[split.axis]);
  const Lanes border = splat(static_cast<float>(split.bin));
  for (const BoundedTriangle* triangle = triangles; triangle != triangles + number; ++triangle) {
    const BoxLanes one(*triangle);
    const Lanes centre = one.centre2();
    const float along = triangle->lower[split.axis] - triangle->negated_upper[split.axis];
    const IntLanes goes_left = (splat(along) - origin) * scale < border;
    // Where all bits are set is no number, which minimum and maximum leave out.
    const Lanes if_left = reinterpret_cast<Lanes>(reinterpret_cast<IntLanes>(centre) | ~goes_left);
    const Lanes if_right = reinterpret_cast<Lanes>(reinterpret_cast<IntLanes>(centre) | goes_left);
    left_low = min(if_left, left_low);
    left_high = if_left > left_high ? if_left : left_high;
    right_low = min(if_right, right_low);
    right_high = if_right > right_high ? if_right : right_high;
    const bool to_left = goes_left[0] != 0;
    std::memcpy(to_left ? left : right, triangle, sizeof(*triangle));
    left += to_left;
    right += !to_left;
  }
  return {{left_low, -left_high}, {right_low, -right_high}};
}

}  // namespace lucarium
