// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/bvh/arrange.h"

#include <cstring>

#include "lucarium/services/bvh/box_lanes.h"

namespace lucarium {

namespace {

constexpr uint32_t max_width = CollapsePlan::max_width;
using Order = std::array<uint8_t, max_width>;

/// Children of the same bits so far: a range of every axis's order.
struct Group {
  uint8_t slot, first, count;
};

class Arrangement {
 public:
  Arrangement(const BinaryBvh& binary, const CollapsePlan& plan, const CollapsePlan::Roots& roots)
      : count_(roots.count) {
    for (uint32_t i = 0; i < max_width; ++i) {
      if (i >= count_) {
        for (auto& of_axis : centre2_) of_axis[i] = -INFINITY;
        continue;
      }
      const BinaryBvh::Subtree& root = roots.of[i];
      const Lanes centre = binary.box(root).centre2();
      for (int axis = 0; axis < 3; ++axis) centre2_[axis][i] = centre[axis];
      ease_[i] = 1 / plan.visits(root);
    }
    for (int axis = 0; axis < 3; ++axis) sort(axis);
    groups_[0] = {0, 0, static_cast<uint8_t>(count_)};
  }

  /// Divides all groups; returns the bits of the order word.
  uint32_t divide(uint32_t bit) {
    int axis = 0;
    float best = -1;
    for (int candidate = 0; candidate < 3; ++candidate) {
      float sum = 0;
      for (uint32_t group = 0; group < group_count_; ++group) sum += separation(groups_[group], candidate);
      if (sum > best) best = sum, axis = candidate;
    }
    float high_ease = 0, low_ease = 0;
    std::array<bool, max_width> high = {};
    for (uint32_t g = 0; g < group_count_; ++g) {
      const Group& group = groups_[g];
      for (uint32_t i = 0; i < group.count; ++i) {
        const uint8_t root = order_[axis][group.first + i];
        high[root] = i < group.count / 2u;
        (high[root] ? high_ease : low_ease) += ease_[root];
      }
    }
    const bool high_first = high_ease > low_ease;
    separate(order_[0], high);
    for (int other = 1; other < 3 && bit > 1; ++other) separate(order_[other], high);
    std::array<Group, max_width> low;
    for (uint32_t g = 0; g < group_count_; ++g) {
      Group& group = groups_[g];
      const auto half = static_cast<uint8_t>(group.count / 2);
      low[g] = {group.slot, static_cast<uint8_t>(group.first + half), static_cast<uint8_t>(group.count - half)};
      group.count = half;
    }
    for (uint32_t g = 0; g < group_count_; ++g) {
      (high_first ? groups_[g] : low[g]).slot |= static_cast<uint8_t>(bit);
      if (group_count_ + g < max_width) groups_[group_count_ + g] = low[g];
    }
    group_count_ *= 2;
    uint32_t order = 0;
    // A ray in negative direction sees the high half first.
    for (uint32_t octant = 0; octant < 8; ++octant)
      if ((octant >> axis & 1) != (high_first ? 1u : 0u)) order |= bit << (4 * octant);
    return order;
  }

  /// Calls place(slot, root) for all children.
  template <class Place>
  void place(Place&& place) const {
    for (uint32_t g = 0; g < group_count_; ++g)
      if (groups_[g].count > 0) place(groups_[g].slot, order_[0][groups_[g].first]);
  }

 private:
  /// High to low; of several the first child comes first.
  void sort(int axis) {
    constexpr IntLanes lanes = {0, 1, 2, 3};
    std::array<int32_t, max_width> rank;
    for (int group = 0; group < static_cast<int>(max_width); group += 4) {
      Lanes own;
      std::memcpy(&own, &centre2_[axis][group], sizeof(own));
      IntLanes before = {};
      for (int i = 0; i < static_cast<int>(count_); ++i) {
        const Lanes other = splat(centre2_[axis][i]);
        before -= (other > own) | ((other == own) & (lanes + splat_int(group) > splat_int(i)));
      }
      std::memcpy(&rank[group], &before, sizeof(before));
    }
    for (uint32_t i = 0; i < count_; ++i) order_[axis][rank[i]] = static_cast<uint8_t>(i);
  }

  /// How far the halves of a group lie apart along an axis.
  float separation(const Group& group, int axis) const {
    if (group.count < 2) return 0;
    const uint32_t middle = group.count / 2u;
    float high = 0, low = 0;
    for (uint32_t i = 0; i < group.count; ++i)
      (i < middle ? high : low) += centre2_[axis][order_[axis][group.first + i]];
    return high / static_cast<float>(middle) - low / static_cast<float>(group.count - middle);
  }

  /// In every group those that are high first, else as they were.
  void separate(Order& order, const std::array<bool, max_width>& high) const {
    Order separated = order;
    for (uint32_t g = 0; g < group_count_; ++g) {
      const Group& group = groups_[g];
      uint32_t to_high = group.first, to_low = group.first + group.count / 2u;
      for (uint32_t i = group.first; i < uint32_t{group.first} + group.count; ++i)
        separated[high[order[i]] ? to_high++ : to_low++] = order[i];
    }
    order = separated;
  }

  uint32_t count_, group_count_ = 1;
  float centre2_[3][max_width];
  float ease_[max_width];
  std::array<Order, 3> order_;
  std::array<Group, max_width> groups_;
};

}  // namespace

Slots arrange(const BinaryBvh& binary, const CollapsePlan& plan, const CollapsePlan::Roots& roots, uint32_t width) {
  Slots slots;
  for (BinaryBvh::Subtree& slot : slots.of) slot.count = 0;
  slots.order = 0;
  Arrangement arrangement(binary, plan, roots);
  for (uint32_t bit = width / 2; bit > 0; bit /= 2) slots.order |= arrangement.divide(bit);
  arrangement.place([&](uint32_t slot, uint32_t root) { slots.of[slot] = roots.of[root]; });
  return slots;
}

}  // namespace lucarium
