// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "micro_rendering/points/point_sampling.h"

namespace lucarium::micro {

/// The order of 2^depth points in which they are the leaves of a complete binary tree (Ritschel et al. 2009, section
/// 2.1, figure 2): each inner node splits what lies
/// below it at the median of the longest axis, but for thin sheets: their sides, and parallel layers that hide each
/// other, are parted first so that no node mixes light that is seen with light that is not. Deterministic; `threads` of
/// 2 and more halve the work.
std::vector<uint32_t> tree_order(std::span<const SampledPoint> points, int threads);

}  // namespace lucarium::micro
