// SPDX-License-Identifier: Apache-2.0
// In which slots of a wide node its children lie.
#pragma once
#include <array>
#include <cstdint>

#include "lucarium/services/bvh/collapse.h"

namespace lucarium {

/// A wide node's children by slot; those of `count` 0 are empty.
struct Slots {
  std::array<BinaryBvh::Subtree, CollapsePlan::max_width> of;
  uint32_t order;  ///< the order word (bvh_layout.h)
};

/// Arranges children such that every bit of a slot's number, from the highest one down, separates its group along one
/// axis, the one of largest separation. Any-hit rays take the highest slot first, wherever they go: 1 marks the half
/// that is cheaper to traverse, which is the better one to try while nothing is known about where hits are. The order
/// word says how others find their nearest child.
Slots arrange(const BinaryBvh& binary, const CollapsePlan& plan, const CollapsePlan::Roots& roots, uint32_t width);

}  // namespace lucarium
