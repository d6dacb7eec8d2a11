// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "point_sampling.h"

namespace lucarium::micro {

/// The order of 2^depth points in which they are the leaves of a complete binary tree: each inner node splits what lies
/// below it at the median of the longest axis, but for thin sheets, whose sides are parted first so that no node mixes
/// their light. Deterministic; `threads` of 2 and more halve the work.
std::vector<uint32_t> tree_order(std::span<const SampledPoint> points, int threads);

}  // namespace lucarium::micro
